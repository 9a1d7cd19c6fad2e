//! What is asked for: which objects, where, how.

use std::sync::Arc;

use glam::DVec3;
use photosite_core::Invalid;

use crate::body::Body;
use crate::pose::{Pose, Turn, point};
use crate::shape::Shape;

/// Objects that want places.
#[derive(Clone, Debug)]
pub struct Request {
    /// The objects, in the order in which their poses are given back.
    pub items: Vec<Item>,
    /// How they get their places.
    pub how: Method,
    /// What stands still already.
    pub fixed: Vec<Fixed>,
    /// The height of the ground, an endless plane, m. None: there is no ground.
    pub ground_height_m: Option<f64>,
    /// How far objects are from each other and from what stands still, m; what they stand on apart. Nothing for objects
    /// that are dropped, which touch each other.
    pub min_distance_m: f64,
    /// Friction and bounce of objects that are dropped.
    pub contact: Contact,
    /// Another seed gives other poses; the same seed gives the same on every machine.
    pub seed: u64,
}

/// An object that wants a place.
#[derive(Clone, Debug)]
pub struct Item {
    /// Its shape.
    pub shape: Arc<Shape>,
    /// How much larger it is than its shape.
    pub scale: f64,
    /// Its density, kg/m³.
    pub density_kg_m3: f64,
}

/// An object that stands still.
#[derive(Clone, Debug)]
pub struct Fixed {
    /// Its shape.
    pub shape: Arc<Shape>,
    /// How much larger it is than its shape.
    pub scale: f64,
    /// Where it is.
    pub pose: Pose,
}

/// A box along the axes of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Its corner of the lowest coordinates, m.
    pub min: DVec3,
    /// Its corner of the highest coordinates, m.
    pub max: DVec3,
}

/// How objects get their places.
#[derive(Clone, Debug)]
pub enum Method {
    /// Their centres of mass lie anywhere in a box, evenly, and nothing holds them.
    Box {
        /// The box.
        region: Region,
        /// How they are turned.
        turn: Turn,
    },
    /// They touch a surface from above, their centres of mass over points that are spread evenly over its area.
    Surface {
        /// Which of the fixed objects has the surface.
        on: usize,
        /// How they are turned.
        turn: Turn,
    },
    /// They stand as they do by themselves, on one face of their convex hull.
    Rest {
        /// What they stand on.
        on: Support,
    },
    /// They fall from a box, any way round, one above the other where they would overlap, until all are at rest.
    Drop {
        /// Where they start.
        region: Region,
        /// Where their centres of mass must come to rest; those that do not are dropped again. None: anywhere.
        keep_in: Option<Region>,
    },
    /// They stand one upon the other, from the first up.
    Stack {
        /// Where the stack stands, m; the height is that of what is below.
        position: DVec3,
    },
}

/// What objects stand on.
#[derive(Clone, Debug)]
pub enum Support {
    /// The ground, with their centres of mass above this box, evenly.
    Ground(Region),
    /// A fixed object, over points that are spread evenly over its upward faces.
    Fixed(usize),
}

/// What happens where two objects touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Coulomb's coefficient of friction.
    pub friction: f64,
    /// The part of the speed with which they part again, 0 to 1.
    pub restitution: f64,
}

impl Default for Contact {
    /// Wood or plastic on wood; hardly a bounce.
    fn default() -> Self {
        Self { friction: 0.5, restitution: 0.1 }
    }
}

impl Item {
    /// An object as its shape has it, of the density of water.
    pub fn new(shape: Arc<Shape>) -> Self {
        Self { shape, scale: 1.0, density_kg_m3: 1000.0 }
    }
}

impl Fixed {
    /// The box around it, along the axes of the world.
    pub fn bounds(&self) -> Region {
        let bounds = Body::new(&self.shape, self.scale, 1.0).bounds(&self.pose);
        Region { min: point(bounds.mins), max: point(bounds.maxs) }
    }
}

impl Region {
    /// Whether a point is inside.
    pub(crate) fn contains(&self, p: DVec3) -> bool {
        p.cmpge(self.min).all() && p.cmple(self.max).all()
    }

    fn check(&self, endless: bool) -> Result<(), Invalid> {
        let (min, max) = (self.min, self.max);
        let is_number = if endless { !(min.is_nan() || max.is_nan()) } else { min.is_finite() && max.is_finite() };
        if is_number && min.cmple(max).all() {
            return Ok(());
        }
        Err(Invalid::new("region", format!("must be the lowest and the highest corner, got {min} and {max}"))
            .help("write min_m = [-0.2, 0, -0.2], max_m = [0.2, 0.3, 0.2]"))
    }
}

impl Request {
    /// Whether everything in it can be meant.
    pub(crate) fn check(&self) -> Result<(), Invalid> {
        let positive = |key: &str, x: f64| match x.is_finite() && x > 0.0 {
            true => Ok(()),
            false => Err(Invalid::new(key, format!("must be above 0, got {x}"))),
        };
        let not_negative = |key: &str, x: f64| match x.is_finite() && x >= 0.0 {
            true => Ok(()),
            false => Err(Invalid::new(key, format!("must be 0 or above, got {x}"))),
        };
        for item in &self.items {
            positive("scale", item.scale)?;
            positive("density_kg_m3", item.density_kg_m3)?;
        }
        for fixed in &self.fixed {
            positive("scale", fixed.scale)?;
        }
        not_negative("min_distance_m", self.min_distance_m)?;
        not_negative("friction", self.contact.friction)?;
        if !(0.0..=1.0).contains(&self.contact.restitution) {
            let message = format!("must be from 0 to 1, got {}", self.contact.restitution);
            return Err(Invalid::new("restitution", message));
        }
        if self.ground_height_m.is_some_and(|height| !height.is_finite()) {
            return Err(Invalid::new("ground_height_m", "must be a number"));
        }
        let is_fixed = |on: usize| match on < self.fixed.len() {
            true => Ok(()),
            false => Err(Invalid::new("surface", "names an object that does not exist")),
        };
        match &self.how {
            Method::Box { region, turn: _ } => region.check(false),
            Method::Surface { on, turn: _ } | Method::Rest { on: Support::Fixed(on) } => is_fixed(*on),
            Method::Rest { on: Support::Ground(region) } => {
                region.check(false)?;
                self.ground()
            }
            Method::Drop { region, keep_in } => {
                region.check(false)?;
                if let Some(keep_in) = keep_in {
                    keep_in.check(true)?;
                }
                if self.fixed.is_empty() { self.ground() } else { Ok(()) }
            }
            Method::Stack { position } => match position.is_finite() {
                true if self.fixed.is_empty() => self.ground(),
                true => Ok(()),
                false => Err(Invalid::new("position_m", "must be numbers")),
            },
        }
    }

    fn ground(&self) -> Result<(), Invalid> {
        match self.ground_height_m {
            Some(_) => Ok(()),
            None => Err(Invalid::new("ground_height_m", "missing: there is nothing for objects to lie on")
                .help("write ground_height_m = 0, or name a surface or a bin")),
        }
    }
}

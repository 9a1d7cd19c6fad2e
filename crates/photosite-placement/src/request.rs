//! Requests of placement: objects, method, surroundings.

use std::sync::Arc;

use glam::DVec3;
use photosite_core::Invalid;

use crate::body::Body;
use crate::pose::{Pose, Turn, point};
use crate::shape::Shape;

/// A request for poses of objects.
#[derive(Clone, Debug)]
pub struct Request {
    /// Objects, in the order in which their poses are returned.
    pub items: Vec<Item>,
    /// Method of placement.
    pub how: Method,
    /// Fixed objects.
    pub fixed: Vec<Fixed>,
    /// Height of the ground, an endless plane, m; `None` for no ground.
    pub ground_height_m: Option<f64>,
    /// Smallest distance of objects from each other and from fixed objects, m, except what they stand on. It has no
    /// effect on dropped objects, which touch each other.
    pub min_distance_m: f64,
    /// Friction and restitution of dropped objects.
    pub contact: Contact,
    /// Seed: other seeds give other poses; equal seeds give equal poses on every machine.
    pub seed: u64,
}

/// An object to be placed.
#[derive(Clone, Debug)]
pub struct Item {
    /// Shape of the object.
    pub shape: Arc<Shape>,
    /// Scale of the object relative to its shape.
    pub scale: f64,
    /// Density, kg/m³.
    pub density_kg_m3: f64,
}

/// An object that does not move.
#[derive(Clone, Debug)]
pub struct Fixed {
    /// Shape of the object.
    pub shape: Arc<Shape>,
    /// Scale of the object relative to its shape.
    pub scale: f64,
    /// Pose of the object.
    pub pose: Pose,
}

/// A box along the axes of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Corner of the lowest coordinates, m.
    pub min: DVec3,
    /// Corner of the highest coordinates, m.
    pub max: DVec3,
}

/// Method of placement.
#[derive(Clone, Debug)]
pub enum Method {
    /// Uniform positions of the centres of mass in a box, where nothing supports the objects.
    Box {
        /// Box of the centres of mass.
        region: Region,
        /// Random rotation.
        turn: Turn,
    },
    /// Contact with a surface from above, with centres of mass over points that are uniform over its area.
    Surface {
        /// Index of the fixed object with the surface.
        on: usize,
        /// Random rotation.
        turn: Turn,
    },
    /// Standing by themselves, on one face of the convex hull.
    Rest {
        /// Support of the objects.
        on: Support,
    },
    /// Fall from a box at any rotation, one object above the other where they would overlap, until all are at rest.
    Drop {
        /// Region of the starts.
        region: Region,
        /// Region in which centres of mass must come to rest; objects outside are dropped again. `None` for anywhere.
        keep_in: Option<Region>,
    },
    /// Stack of the objects one upon the other, from the first up.
    Stack {
        /// Position of the stack, m; the height is that of what is below.
        position: DVec3,
    },
}

/// Support of objects that stand by themselves.
#[derive(Clone, Debug)]
pub enum Support {
    /// Ground, with centres of mass above this box, uniformly.
    Ground(Region),
    /// Fixed object, over points that are uniform over its upward faces.
    Fixed(usize),
}

/// Contact of two objects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Coulomb's coefficient of friction.
    pub friction: f64,
    /// Coefficient of restitution: ratio of the speeds after and before the contact, 0 to 1.
    pub restitution: f64,
}

impl Default for Contact {
    /// Contact of wood or plastic on wood, which hardly bounces.
    fn default() -> Self {
        Self { friction: 0.5, restitution: 0.1 }
    }
}

impl Item {
    /// Object of a shape at scale 1 with the density of water.
    pub fn new(shape: Arc<Shape>) -> Self {
        Self { shape, scale: 1.0, density_kg_m3: 1000.0 }
    }
}

impl Fixed {
    /// Bounding box along the axes of the world.
    pub fn bounds(&self) -> Region {
        let bounds = Body::new(&self.shape, self.scale, 1.0).bounds(&self.pose);
        Region { min: point(bounds.mins), max: point(bounds.maxs) }
    }
}

impl Region {
    /// Whether a point is inside the region.
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
    /// Checks that the request is possible.
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

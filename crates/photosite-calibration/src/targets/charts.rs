//! Sheets of even patches.

use glam::DVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::limits::{counts, length, margin};
use super::{Ink, Target};
use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_core::schema_range::{above, within};

/// Grey steps of even distances in optical density, from light to dark. The origin is the middle.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(default, deny_unknown_fields)]
pub struct GreyWedge {
    /// Number of steps. Left out: 20.
    #[schemars(transform = within(2.0..))]
    pub steps: u32,
    /// Density D = −lg ρ from step to step. Left out: 0.1.
    #[schemars(transform = above(0.0..=6.0))]
    pub density_step: f64,
    /// Density of the lightest. Left out: 0.05.
    #[schemars(transform = within(0.0..=6.0))]
    pub first_density: f64,
    /// Width and height of a step, mm. Left out: [12, 40].
    #[schemars(transform = within(0.01..=100_000.0))]
    pub step_mm: [f64; 2],
    /// Board of the middle density around them, mm. Left out: 10.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(transform = within(0.0..=100_000.0))]
    pub margin_mm: Option<f64>,
}

/// The same reflectance all over. The origin is the middle.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(default, deny_unknown_fields)]
pub struct Flat {
    /// Width and height, mm. Left out: [200, 200].
    #[schemars(transform = within(0.01..=100_000.0))]
    pub size_mm: [f64; 2],
    /// At all wavelengths, 0–1. Left out: 0.9.
    #[schemars(transform = within(0.0..=1.0))]
    pub reflectance: f64,
}

impl Default for GreyWedge {
    fn default() -> Self {
        Self { steps: 20, density_step: 0.1, first_density: 0.05, step_mm: [12.0, 40.0], margin_mm: None }
    }
}

impl Default for Flat {
    fn default() -> Self {
        Self { size_mm: [200.0; 2], reflectance: 0.9 }
    }
}

/// Beyond this density there is nothing left to reflect.
const DARKEST: f64 = 6.0;

impl GreyWedge {
    /// The points are the middles of the steps.
    pub(super) fn draw(&self) -> Result<Target, Invalid> {
        let [steps, _] = counts("steps", [self.steps, 2], 2)?;
        let step = DVec2::new(length("step_mm", self.step_mm[0])?, length("step_mm", self.step_mm[1])?);
        let margin = margin(self.margin_mm, 0.01)?;
        if !(0.0..=DARKEST).contains(&self.first_density) {
            let message = format!("must lie between 0 and {DARKEST}, got {}", self.first_density);
            return Err(Invalid::new("first_density", message));
        }
        let last = self.first_density + self.density_step * f64::from(steps - 1);
        if !(self.density_step > 0.0 && last <= DARKEST) {
            let message = format!("with steps of {} the last of {steps} has the density {last}", self.density_step);
            return Err(Invalid::new("density_step", message).help(format!("write above 0, ending by {DARKEST}")));
        }
        let reflectance = |density: f64| 10f64.powf(-density);
        let end = DVec2::new(step.x * f64::from(steps), step.y) + margin;
        let board = Ink::grey("board", reflectance((self.first_density + last) / 2.0));
        let mut target = Target::sheet(DVec2::splat(-margin), end, vec![board]);
        for i in 0..steps {
            let density = self.first_density + self.density_step * f64::from(i);
            let name = format!("step-{:02}", i + 1);
            target.inks.push(Ink::grey(name.clone(), reflectance(density)));
            let left = DVec2::new(step.x * f64::from(i), 0.0);
            let right = DVec2::new(step.x * f64::from(i + 1), step.y);
            target.add_rectangle(left, right, target.inks.len() - 1);
            target.add_point(name, left + step / 2.0);
        }
        Ok(target.centred())
    }
}

impl Flat {
    /// The point is the middle.
    pub(super) fn draw(&self) -> Result<Target, Invalid> {
        let size = DVec2::new(length("size_mm", self.size_mm[0])?, length("size_mm", self.size_mm[1])?);
        if !(0.0..=1.0).contains(&self.reflectance) {
            let message = format!("must lie between 0 and 1, got {}", self.reflectance);
            return Err(Invalid::new("reflectance", message));
        }
        let mut target = Target::sheet(-size / 2.0, size / 2.0, vec![Ink::grey("sheet", self.reflectance)]);
        target.add_point("middle", DVec2::ZERO);
        Ok(target)
    }
}

//! Checks that refuse descriptions of impossible lenses.

use super::{Falloff, Focus, LensDescription, LensKind, PointSpread, Power, Projection};
use photosite_core::Invalid;

impl LensDescription {
    /// Refuses a description that no lens can have. Keys are those of the capture file's `[lens]` table.
    pub fn validate(&self) -> Result<(), Invalid> {
        let positive = |key: &str, value: f64, unit: &str, example: &str| {
            if value.is_finite() && value > 0.0 {
                return Ok(());
            }
            Err(Invalid::new(key, format!("must be above 0, got {value}{unit}"))
                .help(format!("for example {key} = {example}")))
        };
        match self.kind {
            LensKind::Thin if self.focal_length_m < 0.0 && self.focal_length_m.is_finite() => {}
            LensKind::Thin | LensKind::Pinhole | LensKind::Hole | LensKind::Bare | LensKind::Prescription => {
                positive("focal_length_mm", self.focal_length_m * 1e3, " mm", "16.0")?;
            }
        }
        positive("f_number", self.f_number, "", "2.8")?;
        if let Some(c) = self.circle_of_confusion_m {
            positive("circle_of_confusion_um", c * 1e6, " µm", "30")?;
        }
        self.validate_prescription()?;
        self.validate_focus()?;
        self.validate_elements()?;
        if self.blades == 1 || self.blades == 2 {
            return Err(Invalid::new("blades", format!("{} blades do not enclose an opening", self.blades))
                .help("write 0 for a round aperture, or 3 and more"));
        }
        if self.transmittance.min() < 0.0 || self.transmittance.max() > 1.0 {
            return Err(Invalid::new("transmittance", "must lie between 0 and 1 at every wavelength"));
        }
        if let Some(angle) = self.max_angle_rad {
            positive("max_angle_deg", angle.to_degrees(), "°", "85.0")?;
        }
        if !self.stops.is_empty() && !self.projection.is_flat() {
            let message = "a lens that can see more than a half-space has no axis for stops to stand across";
            return Err(Invalid::new("stops", message).help("remove them, or use a perspective lens"));
        }
        if let Some(i) = self.intrinsics {
            positive("intrinsics.fx", i.fx, " px", "1200.0")?;
            positive("intrinsics.fy", i.fy, " px", "1200.0")?;
        }
        Ok(())
    }

    /// Refuses what the glass of a prescription decides itself.
    fn validate_prescription(&self) -> Result<(), Invalid> {
        let is_wave = self.point_spread == Some(PointSpread::Wave);
        if self.kind != LensKind::Prescription {
            if is_wave {
                let message = "a point spreads by the wave fronts of a prescription, and this lens has none";
                let help = "write prescription = \"double-gauss\", or psf = { kind = \"airy\" } for a lens without aberrations";
                return Err(Invalid::new("psf", message).help(help));
            }
            return Ok(());
        }
        if self.point_spread.is_some() && !is_wave {
            let message = "cannot be combined with lens.prescription: this is that of its glass";
            let help =
                "write psf = { kind = \"wave\" } for its aberrations with diffraction, or remove psf for its rays";
            return Err(Invalid::new("psf", message).help(help));
        }
        if self.prescription.is_none() {
            return Err(Invalid::new("prescription", "is missing").help("for example prescription = \"double-gauss\""));
        }
        let is_distorted = self.projection != Projection::Perspective;
        for (key, is_there, why) in [
            ("intrinsics", self.intrinsics.is_some(), "follow from its glass and the sensor"),
            ("distortion", is_distorted && self.projection.is_flat(), "is that of its glass"),
            ("projection", is_distorted, "is that of its glass"),
            ("falloff", self.falloff == Falloff::None, "follows from what its apertures let through"),
            ("stops", !self.stops.is_empty(), "are its semi-apertures"),
            ("lateral_colour", self.lateral_colour.is_some(), "is that of its glass"),
            ("lensmaker", self.ground.is_some(), "describes another lens"),
            ("supplementary", !self.supplementary.is_empty(), "cannot stand before it yet"),
            ("max_angle_deg", self.max_angle_rad.is_some(), "follows from what its apertures let through"),
            ("min_focus_distance_m", self.min_focus_distance_m.is_some(), "follows from its positions"),
        ] {
            if is_there {
                let message = format!("cannot be combined with lens.prescription: this {why}");
                return Err(Invalid::new(key, message).help(format!("remove {key}")));
            }
        }
        Ok(())
    }

    fn validate_focus(&self) -> Result<(), Invalid> {
        if let Some(nearest) = self.min_focus_distance_m
            && !(nearest.is_finite() && nearest > self.focal_length_m.max(0.0))
        {
            let message = format!("{nearest} m does not lie beyond the focal length of {} m", self.focal_length_m);
            return Err(Invalid::new("min_focus_distance_m", message).help("for example min_focus_distance_m = 0.3"));
        }
        if let Focus::ImageDistance(v) = self.focus
            && !(v.is_finite() && v > 0.0)
        {
            return Err(Invalid::new("image_distance_mm", format!("must be above 0, got {} mm", v * 1e3))
                .help("for example image_distance_mm = 16.5"));
        }
        let diverges = self.focal_length_m < 0.0 && self.supplementary.is_empty();
        match self.focus {
            Focus::Distance(_) | Focus::Infinity | Focus::Autofocus { .. }
                if diverges && self.kind == LensKind::Thin =>
            {
                let f_mm = self.focal_length_m * 1e3;
                let message = format!("a lens of {f_mm} mm makes light diverge, so nothing can be in focus behind it");
                let help =
                    "write image_distance_mm, where the sensor stands; or add [[lens.supplementary]] that converge";
                let key =
                    if matches!(self.focus, Focus::Autofocus { .. }) { "autofocus_px" } else { "focus_distance_m" };
                return Err(Invalid::new(key, message).help(help));
            }
            Focus::Distance(_) | Focus::Infinity | Focus::Autofocus { .. } | Focus::ImageDistance(_) => {}
        }
        let (Focus::Distance(u), LensKind::Thin) = (self.focus, self.kind) else { return Ok(()) };
        let alone = self.supplementary.is_empty();
        if !(u.is_finite() && u > 0.0) || alone && u <= self.focal_length_m {
            let message = format!("{u} m does not lie beyond the focal length of {} m", self.focal_length_m);
            return Err(Invalid::new("focus_distance_m", message)
                .help("a lens can only focus on what is farther away than its focal length; write a larger distance or \"infinity\""));
        }
        match self.min_focus_distance_m {
            Some(nearest) if alone && u < nearest => {
                let message = format!("{u} m is nearer than the lens can be focused on, {nearest} m");
                Err(Invalid::new("focus_distance_m", message)
                    .help("write a larger distance, a smaller min_focus_distance_m, or add a close-up lens, [[lens.supplementary]]"))
            }
            Some(_) | None => Ok(()),
        }
    }

    /// Refuses what the elements of the lens cannot be, and what they cannot go with.
    fn validate_elements(&self) -> Result<(), Invalid> {
        if let Some(ground) = &self.ground {
            ground.validate().map_err(|invalid| invalid.within("lensmaker"))?;
        }
        for (i, element) in self.supplementary.iter().enumerate() {
            let at = |invalid: Invalid| invalid.within(&format!("supplementary[{i}]"));
            if !(element.distance_m.is_finite() && element.distance_m >= 0.0) {
                let message = format!("must be 0 or more, got {} mm", element.distance_m * 1e3);
                return Err(at(Invalid::new("distance_mm", message)));
            }
            match &element.power {
                Power::Constant(power) if !power.is_finite() || *power == 0.0 => {
                    let message = format!("must not be 0, got {power}");
                    return Err(at(Invalid::new("power_dpt", message).help("for example power_dpt = 2")));
                }
                Power::Constant(_) => {}
                Power::Ground(ground) => ground.validate().map_err(at)?,
            }
        }
        let has_elements = self.ground.is_some() || !self.supplementary.is_empty();
        let is_thin = self.kind == LensKind::Thin;
        let other = |key: &str| {
            let name = self.kind.name();
            Err(Invalid::new(key, format!("belongs to a thin lens, and this one is \"{name}\""))
                .help("remove it, or write type = \"thin\""))
        };
        if has_elements && !is_thin {
            return other(if self.ground.is_some() { "lensmaker" } else { "supplementary" });
        }
        if !self.supplementary.is_empty() && !self.projection.is_flat() {
            let message = "go before a lens with a flat image, and this one can see more than a half-space";
            return Err(Invalid::new("supplementary", message).help("remove them, or use a perspective lens"));
        }
        if !self.supplementary.is_empty() && !self.stops.is_empty() {
            let message = "cannot be combined with stops: what these cut off is known of a lens alone";
            return Err(Invalid::new("supplementary", message).help("remove one of them"));
        }
        if !matches!(self.kind, LensKind::Hole | LensKind::Bare) {
            return Ok(());
        }
        let what = if self.kind == LensKind::Hole { "a hole has" } else { "a bare sensor has" };
        let is_bare = self.kind == LensKind::Bare;
        for (key, is_there) in [
            (
                if self.projection.is_flat() { "distortion" } else { "projection" },
                self.projection != Projection::Perspective,
            ),
            ("lateral_colour", self.lateral_colour.is_some()),
            ("stops", is_bare && !self.stops.is_empty()),
            ("psf", is_bare && self.point_spread.is_some()),
            ("intrinsics", is_bare && self.intrinsics.is_some()),
            ("max_angle_deg", is_bare && self.max_angle_rad.is_some()),
            ("falloff", is_bare && self.falloff == Falloff::None),
        ] {
            if is_there {
                return Err(Invalid::new(key, format!("{what} none")).help("remove it, or write type = \"thin\""));
            }
        }
        Ok(())
    }

    /// A distance that autofocus found, or the nearest that the lens can be focused on, where nothing stands before it.
    pub(super) fn within_focus_range(&self, distance_m: f64) -> f64 {
        let nearest = self.min_focus_distance_m.filter(|_| self.supplementary.is_empty());
        nearest.map_or(distance_m, |nearest| distance_m.max(nearest))
    }
}

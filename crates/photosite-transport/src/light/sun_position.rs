//! Position of the sun by date and place: the Astronomical Almanac's approximation
//! ([Michalsky88](photosite_core::references#michalsky88)), right to 0.01° from 1950 to 2050.
//!
//! In: a moment in Universal Time, geographic coordinates. Out: elevation above the horizon and azimuth. Calendars and
//! time zones are left to whoever reads them.

/// Elevation and azimuth of the sun's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunPosition {
    /// Elevation above the horizon, deg, without the atmosphere.
    pub elevation_deg: f64,
    /// Azimuth from north over east, deg, 0–360.
    pub azimuth_deg: f64,
}

impl SunPosition {
    /// Computes the position at `days` after noon of 1 January 2000, UT, at a place by latitude (north is positive) and
    /// longitude (east is positive).
    pub fn new(days: f64, latitude_deg: f64, longitude_deg: f64) -> Self {
        // Mean longitude and anomaly, ecliptic longitude, obliquity.
        let mean_longitude = 280.460 + 0.985_647_4 * days;
        let anomaly = (357.528 + 0.985_600_3 * days).to_radians();
        let longitude = (mean_longitude + 1.915 * anomaly.sin() + 0.020 * (2.0 * anomaly).sin()).to_radians();
        let obliquity = (23.439 - 0.000_000_4 * days).to_radians();
        let right_ascension = (obliquity.cos() * longitude.sin()).atan2(longitude.cos());
        let declination = (obliquity.sin() * longitude.sin()).asin();
        // Hours: of the day, and the mean sidereal time at Greenwich.
        let hour = (days + 0.5).rem_euclid(1.0) * 24.0;
        let sidereal = 6.697_375 + 0.065_709_824_2 * days + hour;
        let hour_angle = (sidereal * 15.0 + longitude_deg).to_radians() - right_ascension;

        let ((sin_d, cos_d), (sin_l, cos_l)) = (declination.sin_cos(), latitude_deg.to_radians().sin_cos());
        let sine = sin_d * sin_l + cos_d * cos_l * hour_angle.cos();
        let (east, north) = (-cos_d * hour_angle.sin(), sin_d * cos_l - cos_d * sin_l * hour_angle.cos());
        Self {
            elevation_deg: sine.clamp(-1.0, 1.0).asin().to_degrees(),
            azimuth_deg: east.atan2(north).to_degrees().rem_euclid(360.0),
        }
    }

    /// Elevation as it is seen, deg: raised by refraction in the standard atmosphere (the same source).
    pub fn apparent_elevation_deg(&self) -> f64 {
        let e = self.elevation_deg;
        let raised = if e > -0.56 {
            3.515_61 * (0.1594 + e * (0.0196 + e * 0.000_02)) / (1.0 + e * (0.505 + e * 0.0845))
        } else {
            0.56
        };
        e + raised
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Days from noon of 1 January 2000 to midnight of a day of 2000 + `years`, by its number in the year.
    fn midnight(years: u32, day_of_year: u32) -> f64 {
        f64::from(years * 365 + years.div_ceil(4) + day_of_year) - 1.5
    }

    /// Error of the approximation, with the parallax of the sun that it leaves out.
    const TOLERANCE_DEG: f64 = 0.01 + 0.0024;

    #[test]
    fn the_example_of_the_national_renewable_energy_laboratory() {
        // I. Reda, A. Andreas, "Solar Position Algorithm for Solar Radiation Applications", NREL/TP-560-34302 (2008),
        // appendix A.5: 17 October 2003, 12:30:30 at 7 h west of Greenwich; elevation without refraction and azimuth.
        let sun = SunPosition::new(midnight(3, 290) + (19.0 + 30.5 / 60.0) / 24.0, 39.742_476, -105.1786);
        assert!((sun.elevation_deg - 39.872_046).abs() < TOLERANCE_DEG, "{sun:?}");
        assert!((sun.azimuth_deg - 194.340_241).abs() < TOLERANCE_DEG / 39.87f64.to_radians().cos(), "{sun:?}");
        // Its refraction is that of 820 mbar at 11 °C, 0.0163°, less than that of the standard atmosphere. The fit
        // gives the zenith 0.01°, where there is none.
        let raised = sun.apparent_elevation_deg() - sun.elevation_deg;
        assert!((raised - 0.0163 * 1013.25 / 820.0 * 284.0 / 288.0).abs() < 0.01, "{raised}");
    }

    #[test]
    fn the_declination_of_meeus() {
        // J. Meeus, "Astronomical Algorithms" (1998), example 25.a: 13 October 1992, 0 h, −7.785 07°: the sun's height
        // at the north pole. 8 years before 2000 there were two leap days, of 1992 and 1996.
        let days = midnight(0, 287) - 366.0 - f64::from(7 * 365 + 1);
        let sun = SunPosition::new(days, 90.0, 0.0);
        assert!((sun.elevation_deg + 7.785_07).abs() < TOLERANCE_DEG, "{sun:?}");
    }

    #[test]
    fn refraction_lifts_the_setting_sun_by_its_own_width() {
        // At the horizon 34' (Meeus, ch. 16), 29' at its apparent height of it.
        let lifted = |elevation_deg| {
            let sun = SunPosition { elevation_deg, azimuth_deg: 0.0 };
            sun.apparent_elevation_deg() - elevation_deg
        };
        assert!((lifted(-0.56) * 60.0 - 34.0).abs() < 1.0, "{}", lifted(-0.56));
        assert!(lifted(90.0) < 0.011 && lifted(10.0) > lifted(20.0));
    }
}

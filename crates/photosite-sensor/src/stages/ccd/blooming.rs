//! Blooming: charge that a well cannot hold flows over the low barriers between the pixels of a column into the nearest
//! wells with room, half of it up and half of it down. The channel stops between columns are too high for it.
//!
//! An anti-blooming drain beside the pixel takes a part of what overflows away first; data sheets say up to how many
//! times the saturating light it does so.

/// Lets a column of charges (e⁻) overflow. The drain of a pixel takes up to `drain_e`. What reaches an end of the
/// column is lost, too. Returns the lost electrons, so that column and loss together keep the charge.
pub(crate) fn overflow(column: &mut [f64], full_well_e: f64, drain_e: f64) -> f64 {
    // Downwards; the half that goes up waits on top of its full well.
    let (mut lost, mut down) = (0.0, 0.0);
    for charge in column.iter_mut() {
        let excess = *charge - full_well_e;
        if excess > 0.0 {
            let drained = excess.min(drain_e);
            // Whole electrons go either way, so that sums stay exact.
            let up = ((excess - drained) / 2.0).floor();
            lost += drained;
            down += excess - drained - up;
            *charge = full_well_e + up;
        } else {
            let taken = down.min(-excess);
            *charge += taken;
            down -= taken;
        }
    }
    let mut up = 0.0;
    for charge in column.iter_mut().rev() {
        let excess = *charge - full_well_e;
        if excess > 0.0 {
            up += excess;
            *charge = full_well_e;
        } else {
            let taken = up.min(-excess);
            *charge += taken;
            up -= taken;
        }
    }
    lost + down + up
}

#[cfg(test)]
mod tests {
    use super::*;

    const WELL: f64 = 1000.0;

    #[test]
    fn a_bright_pixel_fills_as_many_to_either_side() {
        let mut column = vec![0.0; 21];
        column[10] = 8.0 * WELL;
        assert_eq!(overflow(&mut column, WELL, 0.0), 0.0);
        let mut expected = vec![0.0; 21];
        expected[7..14].fill(WELL);
        (expected[6], expected[14]) = (WELL / 2.0, WELL / 2.0);
        assert_eq!(column, expected);
    }

    #[test]
    fn charge_is_conserved_and_no_well_overfull() {
        let start: Vec<f64> =
            (0..200).map(|i| if i % 37 < 4 { (i * 7919 % 12_000) as f64 } else { (i % 900) as f64 + 0.5 }).collect();
        for drain in [0.0, 1500.0, 1e9] {
            let mut column = start.clone();
            let lost = overflow(&mut column, WELL, drain);
            // Whole and half electrons below 2⁵² add up exactly.
            assert_eq!(column.iter().sum::<f64>() + lost, start.iter().sum::<f64>());
            assert!(column.iter().all(|&charge| charge <= WELL));
            // A pixel never loses what its well could hold.
            assert!(column.iter().zip(&start).all(|(after, before)| *after >= before.min(WELL)));
        }
    }

    #[test]
    fn a_drain_that_is_large_enough_keeps_the_neighbours_dark() {
        let mut column = vec![100.0; 9];
        column[4] = 50.0 * WELL;
        assert_eq!(overflow(&mut column, WELL, 49.0 * WELL), 49.0 * WELL);
        assert_eq!(column, [100.0, 100.0, 100.0, 100.0, WELL, 100.0, 100.0, 100.0, 100.0]);
    }

    #[test]
    fn a_column_with_room_is_left_alone() {
        let mut column = [0.0, WELL, 12.5, -3.0];
        assert_eq!(overflow(&mut column, WELL, 0.0), 0.0);
        assert_eq!(column, [0.0, WELL, 12.5, -3.0]);
        // Light that overfills everything ends up at the ends.
        let mut column = [3.0 * WELL; 3];
        assert_eq!(overflow(&mut column, WELL, 0.0), 6.0 * WELL);
        assert_eq!(column, [WELL; 3]);
    }
}

//! Triangulation of polygons, concave ones included.

use glam::{DVec2, DVec3, Vec3};

/// Largest number of corners of a polygon. Triangulating a concave one takes time by their square, or their cube where
/// it winds: seconds for this number.
pub(crate) const MOST_CORNERS: usize = 5_000;

/// Calls `emit` with the positions, in `corners`, of each triangle's corners. Convex polygons become a fan around their
/// first corner; concave ones are cut by clipping ears ([Meisters75](photosite_core::references#meisters75)). A polygon
/// that crosses itself or has no area is fanned as well, since it has no correct triangulation.
pub(crate) fn triangulate(corners: &[Vec3], mut emit: impl FnMut([usize; 3])) {
    let n = corners.len();
    if n == 3 {
        return emit([0, 1, 2]);
    }
    let flat = project(corners);
    if flat.as_ref().is_none_or(|flat| (0..n).all(|i| turn(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) >= 0.0)) {
        return (1..n.saturating_sub(1)).for_each(|i| emit([0, i, i + 1]));
    }
    let Some(flat) = flat else { return };
    let mut left: Vec<usize> = (0..n).collect();
    while left.len() > 3 {
        let n = left.len();
        let ear = (0..n).find(|&i| is_ear(&flat, &left, i)).unwrap_or(1);
        emit([left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]]);
        left.remove(ear);
    }
    emit([left[0], left[1], left[2]]);
}

/// Corners in the plane of the polygon, counter-clockwise; `None` if it has no area.
fn project(corners: &[Vec3]) -> Option<Vec<DVec2>> {
    let wide = |i: usize| corners[i % corners.len()].as_dvec3();
    // Newell's normal: the sum over the edges is right for polygons that are not quite flat, too.
    let origin = wide(0);
    let normal: DVec3 = (0..corners.len()).map(|i| (wide(i) - origin).cross(wide(i + 1) - origin)).sum();
    let (x, y) = normal.try_normalize()?.any_orthonormal_pair();
    Some(corners.iter().map(|c| c.as_dvec3() - origin).map(|c| DVec2::new(c.dot(x), c.dot(y))).collect())
}

/// Twice the signed area of a triangle: positive for a turn to the left.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - b)
}

/// Whether corner number `i` of the remaining ones can be cut off: it turns left, and no other corner lies in its
/// triangle.
fn is_ear(flat: &[DVec2], left: &[usize], i: usize) -> bool {
    let n = left.len();
    let (before, after) = ((i + n - 1) % n, (i + 1) % n);
    let [a, b, c] = [before, i, after].map(|i| flat[left[i]]);
    let contains = |p: DVec2| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
    // Corners that coincide with one of the triangle's, as where a hole is joined to the outline, do not count.
    let others = left.iter().map(|&j| flat[j]).filter(|&p| p != a && p != b && p != c);
    turn(a, b, c) > 0.0 && !others.into_iter().any(contains)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(corners: &[[f32; 2]]) -> Vec<[usize; 3]> {
        // In a tilted plane, to exercise the projection.
        let corners: Vec<Vec3> = corners.iter().map(|&[x, y]| Vec3::new(x, y, 0.5 * x - 0.25 * y)).collect();
        let mut found = Vec::new();
        triangulate(&corners, |triangle| found.push(triangle));
        found
    }

    fn area(corners: &[[f32; 2]], triangle: &[usize; 3]) -> f64 {
        let [a, b, c] = triangle.map(|i| DVec2::new(f64::from(corners[i][0]), f64::from(corners[i][1])));
        0.5 * turn(a, b, c)
    }

    /// Area by the shoelace formula.
    fn polygon_area(corners: &[[f32; 2]]) -> f64 {
        let n = corners.len();
        (0..n)
            .map(|i| (corners[i], corners[(i + 1) % n]))
            .map(|(a, b)| 0.5 * f64::from(a[0] * b[1] - b[0] * a[1]))
            .sum()
    }

    #[test]
    fn convex_polygons_become_fans() {
        assert_eq!(triangles(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.]]), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(triangles(&[[0., 0.], [1., 0.], [0., 1.]]), [[0, 1, 2]]);
    }

    #[test]
    fn concave_polygons_are_covered_once() {
        let arrow: &[[f32; 2]] = &[[0., 0.], [2., 2.], [4., 0.], [2., 5.]];
        let comb: &[[f32; 2]] = &[
            [0., 0.],
            [5., 0.],
            [5., 3.],
            [4., 3.],
            [4., 1.],
            [3., 1.],
            [3., 3.],
            [2., 3.],
            [2., 1.],
            [1., 1.],
            [1., 3.],
            [0., 3.],
        ];
        // A square with a square hole, joined along an edge that is walked twice.
        let ring: &[[f32; 2]] =
            &[[0., 0.], [4., 0.], [4., 4.], [0., 4.], [0., 0.], [1., 1.], [1., 3.], [3., 3.], [3., 1.], [1., 1.]];
        for polygon in [arrow, comb, ring] {
            let found = triangles(polygon);
            assert_eq!(found.len(), polygon.len() - 2);
            assert!(found.iter().all(|t| area(polygon, t) >= 0.0), "{found:?}");
            let sum: f64 = found.iter().map(|t| area(polygon, t)).sum();
            // Positive pieces whose areas add up to that of the polygon cannot overlap or stick out. Coordinates are
            // small integers, so sums are exact.
            assert_eq!(sum, polygon_area(polygon), "{found:?}");
        }
    }

    #[test]
    fn the_turning_sense_follows_the_corners() {
        let clockwise: Vec<[f32; 2]> = vec![[2., 5.], [4., 0.], [2., 2.], [0., 0.]];
        assert!(triangles(&clockwise).iter().all(|t| area(&clockwise, t) < 0.0));
    }

    #[test]
    fn polygons_without_area_do_no_harm() {
        assert_eq!(triangles(&[[0., 0.]; 5]).len(), 3);
        assert_eq!(triangles(&[[0., 0.], [1., 1.], [2., 2.], [3., 3.]]).len(), 2);
        assert_eq!(triangles(&[[0., 0.], [2., 2.], [2., 0.], [0., 2.]]).len(), 2, "a bow tie");
        assert!(triangles(&[[0., 0.], [1., 0.]]).is_empty());
    }
}

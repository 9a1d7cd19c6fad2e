//! Scenes of few triangles: each triangle is shown to as many rays at a time as a register has lanes, which takes less time than
//! to find those that may be in the way of each ray. A Cornell box of 36 triangles is rendered 1.2 times as fast as through the
//! hierarchy with sixteen lanes, and 1.05 times with eight; with 60 triangles it is 1.12 and 0.97 times.
//!
//! The test is that of [`triangle_block`](super::triangle_block), operation by operation, so that a ray meets a triangle at the
//! same distance in either way.

use std::ops::Range;

use glam::Vec3;

use super::accel::HitFilter;
use super::bounds::Bounds;
use super::triangle_block::{distance_error, double_area, error_of_sum, longest_axis};
use super::{Geometry, Hit, Ray, Sphere};
use photosite_core::math::Vector;
use photosite_simd::{LaneMask, MOST_LANES, ManyLanes, with_most_lanes};

/// Triangles, and vertices, of a scene that is swept, at most.
const MOST: usize = 48;

/// Rays that are put in order together.
const TOGETHER: usize = 256;

/// All triangles of a small scene.
#[derive(Clone, Debug)]
pub(super) struct Sweep {
    /// Each once.
    vertices: Vec<Vec3>,
    triangles: Vec<Swept>,
    /// Spheres with what they are called.
    spheres: Vec<(Sphere, u32)>,
    bounds: Bounds,
}

#[derive(Clone, Copy, Debug)]
struct Swept {
    /// Indices of its vertices.
    corners: [u8; 3],
    /// What it is called.
    id: u32,
}

impl Sweep {
    /// Of a range of triangles, with the spheres that some stand for, all within `bounds`; `None` where they are too many.
    pub(super) fn new(geometry: &Geometry, range: Range<u32>, bounds: Bounds) -> Option<Self> {
        if range.len() > MOST {
            return None;
        }
        let mut sweep = Self { vertices: Vec::new(), triangles: Vec::new(), spheres: Vec::new(), bounds };
        for id in range {
            if let Some(sphere) = geometry.sphere(id) {
                sweep.spheres.push((sphere, id));
                continue;
            }
            let mut index = |corner: Vec3| {
                let bits = |v: &Vec3| v.to_array().map(f32::to_bits);
                let known = sweep.vertices.iter().position(|vertex| bits(vertex) == bits(&corner));
                known.unwrap_or_else(|| {
                    sweep.vertices.push(corner);
                    sweep.vertices.len() - 1
                }) as u8
            };
            let corners = geometry.corners(id).map(&mut index);
            sweep.triangles.push(Swept { corners, id });
        }
        (sweep.vertices.len() <= MOST).then_some(sweep)
    }

    /// The nearest hits of several rays that `filter` accepts, in the order of the rays.
    pub(super) fn closest_each<F: HitFilter>(&self, rays: &[Ray], filter: &F, hits: &mut [Option<Hit>]) {
        closest_each(self, rays, filter, hits);
    }

    /// Whether anything that `filter` accepts is in the way of each of several rays.
    pub(super) fn occluded_each<F: HitFilter>(&self, rays: &[Ray], filter: &F, occluded: &mut [bool]) {
        occluded_each(self, rays, filter, occluded);
    }
}

with_most_lanes! {
    fn closest_each<F: HitFilter>(sweep: &Sweep, rays: &[Ray], filter: &F, hits: &mut [Option<Hit>]) -> () =
        closest_each_in
}

#[inline(always)]
fn closest_each_in<L: ManyLanes, F: HitFilter>(sweep: &Sweep, rays: &[Ray], filter: &F, hits: &mut [Option<Hit>]) {
    let mut sheared = Sheared::<L>::nothing();
    for (rays, hits) in rays.chunks(TOGETHER).zip(hits.chunks_mut(TOGETHER)) {
        let by_axis = ByAxis::new(rays);
        for (axis, members) in by_axis.groups(L::COUNT) {
            let group = RayGroup::<L>::new(rays, members, axis);
            sheared.look(sweep, &group);
            let nothing = [L::splat(0.0); 3];
            let mut query = Closest { nearest: group.t_max, weights: nothing, which: L::splat(f32::INFINITY) };
            sheared.sweep(sweep, &group, filter, &mut query);
            let [v, w, sum] = query.weights;
            let (t, b1, b2) = (query.nearest.store_many(), (v / sum).store_many(), (w / sum).store_many());
            let which = query.which.store_many();
            for (lane, &member) in members.iter().enumerate() {
                let (which, t) = (which[lane] as usize, t[lane]);
                let met = match sweep.triangles.get(which) {
                    Some(met) => Some((met.id, [b1[lane], b2[lane]])),
                    None => sweep.spheres.get(which - sweep.triangles.len()).map(|(sphere, id)| {
                        let point = rays[usize::from(member)].at(t);
                        (*id, sphere.numbers(point))
                    }),
                };
                if let Some((triangle, barycentric)) = met {
                    hits[usize::from(member)] = Some(Hit { t, barycentric, triangle, placement: 0 });
                }
            }
        }
    }
}

with_most_lanes! {
    fn occluded_each<F: HitFilter>(sweep: &Sweep, rays: &[Ray], filter: &F, occluded: &mut [bool]) -> () =
        occluded_each_in
}

#[inline(always)]
fn occluded_each_in<L: ManyLanes, F: HitFilter>(sweep: &Sweep, rays: &[Ray], filter: &F, occluded: &mut [bool]) {
    let mut sheared = Sheared::<L>::nothing();
    for (rays, occluded) in rays.chunks(TOGETHER).zip(occluded.chunks_mut(TOGETHER)) {
        let by_axis = ByAxis::new(rays);
        for (axis, members) in by_axis.groups(L::COUNT) {
            let group = RayGroup::<L>::new(rays, members, axis);
            sheared.look(sweep, &group);
            let mut query = Occluded { t_max: group.t_max, met: 0, all: u32::MAX >> (32 - members.len()) };
            sheared.sweep(sweep, &group, filter, &mut query);
            for (lane, &member) in members.iter().enumerate() {
                occluded[usize::from(member)] = query.met >> lane & 1 != 0;
            }
        }
    }
}

/// The numbers of rays, at most [`TOGETHER`], by the axis along which their direction is longest.
struct ByAxis {
    numbers: [[u8; TOGETHER]; 3],
    counts: [usize; 3],
}

impl ByAxis {
    #[inline(always)]
    fn new(rays: &[Ray]) -> Self {
        let mut sorted = Self { numbers: [[0; TOGETHER]; 3], counts: [0; 3] };
        for (number, ray) in rays.iter().enumerate() {
            let axis = longest_axis(ray.direction);
            sorted.numbers[axis][sorted.counts[axis]] = number as u8;
            sorted.counts[axis] += 1;
        }
        sorted
    }

    /// So many at a time, with their axis.
    #[inline(always)]
    fn groups(&self, size: usize) -> impl Iterator<Item = (usize, &[u8])> {
        let lists = self.numbers.iter().zip(self.counts).enumerate();
        lists.flat_map(move |(axis, (numbers, count))| numbers[..count].chunks(size).map(move |group| (axis, group)))
    }
}

/// Rays of one axis, one in each lane.
struct RayGroup<'a, L> {
    rays: &'a [Ray],
    /// Numbers of those in the first lanes. In others are copies of the first.
    members: &'a [u8],
    origin: [L; 3],
    direction: [L; 3],
    /// Where x, y and z of the sheared space come from.
    axes: [usize; 3],
    shear: [L; 3],
    /// |1/shear z|.
    inverse_scale: L,
    t_max: L,
}

impl<'a, L: ManyLanes> RayGroup<'a, L> {
    #[inline(always)]
    fn new(rays: &'a [Ray], members: &'a [u8], kz: usize) -> Self {
        let mut numbers = [[0.0; MOST_LANES]; 7];
        for lane in 0..L::COUNT {
            let Ray { origin, direction, t_max, .. } = &rays[usize::from(*members.get(lane).unwrap_or(&members[0]))];
            numbers[0][lane] = origin.x;
            numbers[1][lane] = origin.y;
            numbers[2][lane] = origin.z;
            numbers[3][lane] = direction.x;
            numbers[4][lane] = direction.y;
            numbers[5][lane] = direction.z;
            numbers[6][lane] = *t_max;
        }
        let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
        let direction = [L::load_many(&numbers[3]), L::load_many(&numbers[4]), L::load_many(&numbers[5])];
        let scale = L::splat(1.0) / direction[kz];
        Self {
            rays,
            members,
            origin: [L::load_many(&numbers[0]), L::load_many(&numbers[1]), L::load_many(&numbers[2])],
            direction,
            axes: [kx, ky, kz],
            shear: [direction[kx] * scale, direction[ky] * scale, scale],
            inverse_scale: L::splat(1.0) / scale.abs(),
            t_max: L::load_many(&numbers[6]),
        }
    }
}

/// What is asked of the triangles.
trait Query<L: ManyLanes> {
    /// Rays that end here.
    fn nearest(&self) -> L;
    /// Takes the hits of a triangle; returns whether nothing more needs to be known.
    fn take(&mut self, is_met: L::Mask, which: usize, t: L, weights: [L; 3]) -> bool;
}

struct Closest<L> {
    nearest: L,
    /// Barycentric weights of the second and third corner, and what to divide them by.
    weights: [L; 3],
    /// Number of the triangle.
    which: L,
}

impl<L: ManyLanes> Query<L> for Closest<L> {
    #[inline(always)]
    fn nearest(&self) -> L {
        self.nearest
    }

    #[inline(always)]
    fn take(&mut self, is_met: L::Mask, which: usize, t: L, weights: [L; 3]) -> bool {
        self.nearest = L::select(is_met, t, self.nearest);
        self.which = L::select(is_met, L::splat(which as f32), self.which);
        for (own, weight) in self.weights.iter_mut().zip(weights) {
            *own = L::select(is_met, weight, *own);
        }
        false
    }
}

struct Occluded<L> {
    t_max: L,
    /// Lanes that have met something.
    met: u32,
    /// Lanes with rays of their own.
    all: u32,
}

impl<L: ManyLanes> Query<L> for Occluded<L> {
    #[inline(always)]
    fn nearest(&self) -> L {
        self.t_max
    }

    #[inline(always)]
    fn take(&mut self, is_met: L::Mask, _: usize, _: L, _: [L; 3]) -> bool {
        self.met |= is_met.bits();
        self.met & self.all == self.all
    }
}

/// The vertices as a group of rays sees them.
struct Sheared<L> {
    vertices: [[L; 3]; MOST],
    /// Hits with a larger t·|sum| are farther than twice their rounding error.
    sure: L,
}

impl<L: ManyLanes> Sheared<L> {
    #[inline(always)]
    fn nothing() -> Self {
        Self { vertices: [[L::splat(0.0); 3]; MOST], sure: L::splat(0.0) }
    }

    /// Looks at all vertices along a group of rays.
    #[inline(always)]
    fn look(&mut self, sweep: &Sweep, group: &RayGroup<'_, L>) {
        let [kx, ky, kz] = group.axes;
        let [sx, sy, sz] = group.shear;
        for (sheared, vertex) in self.vertices.iter_mut().zip(&sweep.vertices) {
            let x = L::splat(vertex[kx]) - group.origin[kx];
            let y = L::splat(vertex[ky]) - group.origin[ky];
            let z = L::splat(vertex[kz]) - group.origin[kz];
            *sheared = [x - sx * z, y - sy * z, sz * z];
        }
        let (low, high) = sweep.bounds;
        let mut reach = L::splat(0.0);
        for axis in 0..3 {
            let origin = group.origin[axis];
            reach = reach.most((L::splat(low[axis]) - origin).abs()).most((L::splat(high[axis]) - origin).abs());
        }
        // Shears are at most 1. What is beyond that pays for roundings.
        let across = reach * L::splat(2.01);
        let largest = [across, across, reach * sz.abs() * L::splat(1.01)];
        self.sure = error_of_sum(largest, across * across * L::splat(2.01), group.inverse_scale) * L::splat(2.0);
    }

    /// Shows everything to the rays that have [`look`](Self::look)ed at the vertices.
    #[inline(always)]
    fn sweep<F: HitFilter>(&self, sweep: &Sweep, group: &RayGroup<'_, L>, filter: &F, query: &mut impl Query<L>) {
        let zero = L::splat(0.0);
        let ([ox, oy, oz], [dx, dy, dz]) = (group.origin, group.direction);
        let (origin, direction) = (Vector::new(ox, oy, oz), Vector::new(dx, dy, dz));
        for (which, (sphere, id)) in (sweep.triangles.len()..).zip(&sweep.spheres) {
            for t in sphere.sides(origin, direction) {
                let mut is_met = zero.is_below(t) & t.is_below(query.nearest());
                if !F::ACCEPTS_ALL {
                    is_met = is_met & group.accepted_on(filter, (sphere, *id), is_met.bits(), t.store_many());
                }
                if is_met.bits() != 0 && query.take(is_met, which, t, [zero; 3]) {
                    return;
                }
            }
        }
        for (which, triangle) in sweep.triangles.iter().enumerate() {
            let [i, j, k] = triangle.corners;
            let a = self.vertices[usize::from(i) % MOST];
            let b = self.vertices[usize::from(j) % MOST];
            let c = self.vertices[usize::from(k) % MOST];
            let (u, v, w) = (double_area(c, b), double_area(a, c), double_area(b, a));
            let (smallest, largest) = (u.least(v).least(w), u.most(v).most(w));
            let inside = zero.is_at_most(smallest) | largest.is_at_most(zero);
            let sum = u + v + w;
            let along = u * a[2] + v * b[2] + w * c[2];
            // Of a triangle that is seen edge on, t is not a number.
            let t = along / sum;
            let mut is_met = inside & zero.is_below(t) & t.is_below(query.nearest());
            if is_met.bits() == 0 {
                continue;
            }
            if (is_met & !self.sure.is_below(along.abs())).bits() != 0 {
                is_met = is_met & distance_error([a, b, c], [u, v, w], sum, group.inverse_scale).is_below(t);
            }
            if !F::ACCEPTS_ALL {
                let weights = [(v / sum).store_many(), (w / sum).store_many()];
                is_met = is_met & group.accepted(filter, triangle.id, is_met.bits(), weights);
            }
            if query.take(is_met, which, t, [v, w, sum]) {
                return;
            }
        }
    }
}

impl<L: ManyLanes> RayGroup<'_, L> {
    /// Which of the lanes that meet a sphere there `filter` accepts.
    #[inline(always)]
    fn accepted_on<F: HitFilter>(
        &self,
        filter: &F,
        (sphere, id): (&Sphere, u32),
        met: u32,
        t: [f32; MOST_LANES],
    ) -> L::Mask {
        let mut numbers = [[0.0; MOST_LANES]; 2];
        for (lane, &member) in self.members.iter().enumerate() {
            [numbers[0][lane], numbers[1][lane]] = sphere.numbers(self.rays[usize::from(member)].at(t[lane]));
        }
        self.accepted(filter, id, met, numbers)
    }

    /// Which of the lanes that are met `filter` accepts.
    #[inline(always)]
    fn accepted<F: HitFilter>(&self, filter: &F, id: u32, met: u32, [b1, b2]: [[f32; MOST_LANES]; 2]) -> L::Mask {
        let mut accepted = [0.0; MOST_LANES];
        for (lane, &member) in self.members.iter().enumerate() {
            let is_met = met >> lane & 1 != 0;
            if is_met && filter.accept(id, [b1[lane], b2[lane]], &self.rays[usize::from(member)]) {
                accepted[lane] = 1.0;
            }
        }
        L::splat(0.0).is_below(L::load_many(&accepted))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::accel_tests::{Numbers, Sieve, geometry, in_world, mixed};
    use crate::geometry::{Accel, AcceptAll};
    use photosite_core::math::warp;
    use photosite_simd::Portable;

    /// A scene without its sweep.
    fn hierarchy(accel: &Accel) -> Accel {
        let mut accel = accel.clone();
        accel.sweep = None;
        accel
    }

    /// Rays in all directions, some of which are short or run along axes, and some of which start in a triangle.
    fn rays(numbers: &mut Numbers, count: usize, triangles: &[[Vec3; 3]]) -> Vec<Ray> {
        let ray = |i: usize| {
            let mut direction = warp::uniform_sphere([numbers.next(), numbers.next()]);
            if i.is_multiple_of(5) {
                direction[i / 5 % 3] = if i.is_multiple_of(2) { 0.0 } else { -0.0 };
            }
            if i.is_multiple_of(7) {
                direction *= 1e3;
            }
            let origin = match i % 4 {
                0 => {
                    let [a, b, c] = triangles[i / 4 % triangles.len()];
                    a * 0.3 + b * 0.3 + c * 0.4
                }
                _ => numbers.point() * 2.0 - 0.5,
            };
            let t_max = if i.is_multiple_of(3) { 0.7 } else { f32::INFINITY };
            Ray { t_max, ..Ray::new(origin, direction) }
        };
        (0..count).map(ray).collect()
    }

    /// What each set of registers finds, and what the hierarchy does.
    fn compare<F: HitFilter>(accel: &Accel, rays: &[Ray], filter: &F, what: &str) -> usize {
        let sweep = accel.sweep.as_ref().expect("few triangles");
        let (mut expected, mut occluded) = (vec![], vec![]);
        hierarchy(accel).closest_each(rays, filter, &mut expected);
        hierarchy(accel).occluded_each(rays, filter, &mut occluded);
        let (mut hits, mut is_occluded) = (vec![None; rays.len()], vec![false; rays.len()]);
        sweep.closest_each(rays, filter, &mut hits);
        sweep.occluded_each(rays, filter, &mut is_occluded);
        assert_eq!(hits, expected, "{what}, most lanes");
        assert_eq!(is_occluded, occluded, "{what}, most lanes");
        let (mut hits, mut is_occluded) = (vec![None; rays.len()], vec![false; rays.len()]);
        closest_each_in::<Portable, F>(sweep, rays, filter, &mut hits);
        occluded_each_in::<Portable, F>(sweep, rays, filter, &mut is_occluded);
        assert_eq!(hits, expected, "{what}, portable");
        assert_eq!(is_occluded, occluded, "{what}, portable");
        expected.iter().flatten().count()
    }

    #[test]
    fn a_sweep_meets_what_the_hierarchy_meets() {
        let mut numbers = Numbers(19);
        for (count, scale, offset) in
            [(1, 1.0, 0.0), (16, 1.0, 0.0), (16, 1e-6, 0.0), (16, 1e6, 0.0), (16, 1.0, 1000.0)]
        {
            let triangles: Vec<_> = (0..count)
                .map(|_| {
                    let centre = numbers.point();
                    [0, 1, 2].map(|_| centre + (numbers.point() - 0.5) * 0.8)
                })
                .collect();
            for ray_count in [0, 1, 15, 16, 17, 300, 3000] {
                let mut rays = rays(&mut numbers, ray_count, &triangles);
                for ray in &mut rays {
                    ray.origin = ray.origin * scale + offset;
                    ray.direction *= scale;
                }
                let placed: Vec<_> = triangles.iter().map(|t| t.map(|corner| corner * scale + offset)).collect();
                let accel = in_world(&geometry(&placed));
                let what = format!("{count} triangles, scale {scale}, offset {offset}, {ray_count} rays");
                let hits = compare(&accel, &rays, &AcceptAll, &what);
                assert!(hits > 0 || ray_count < 300, "{what}: {hits} hits");
                compare(&accel, &rays, &Sieve, &format!("{what}, sieve"));
            }
        }
    }

    #[test]
    fn spheres_are_swept_too() {
        let mut numbers = Numbers(29);
        for (triangles, spheres) in [(8, 3), (0, 5)] {
            let (g, _) = mixed(&mut numbers, triangles, spheres);
            let accel = in_world(&g);
            let corners: Vec<_> = (0..g.triangles.len() as u32).map(|triangle| g.corners(triangle)).collect();
            let rays = rays(&mut numbers, 3000, &corners);
            let what = format!("{triangles} triangles, {spheres} spheres");
            let hits = compare(&accel, &rays, &AcceptAll, &what);
            assert!(hits > 100, "{what}: {hits} hits");
            // One side may have a hole where the other has none.
            compare(&accel, &rays, &Patches, &format!("{what}, patches"));
        }
    }

    /// Everything is there only here and there.
    struct Patches;

    impl HitFilter for Patches {
        fn accept(&self, _: u32, [u, v]: [f32; 2], _: &Ray) -> bool {
            (u * 7.0).sin() * (v * 5.0).cos() > 0.0
        }
    }

    #[test]
    fn few_triangles_are_swept_and_many_are_not() {
        let mut numbers = Numbers(2);
        for (count, is_swept) in [(16, true), (17, false), (49, false)] {
            let triangles: Vec<_> = (0..count).map(|_| [0, 1, 2].map(|_| numbers.point())).collect();
            assert_eq!(
                in_world(&geometry(&triangles)).sweep.is_some(),
                is_swept,
                "{count} triangles of their own vertices"
            );
        }
        let corner = |i: u32| Vec3::new((i % 2) as f32, (i / 2) as f32, 0.0);
        let strip = |count: u32| (0..count).map(|i| [corner(i), corner(i + 1), corner(i + 2)]).collect::<Vec<_>>();
        assert!(in_world(&geometry(&strip(46))).sweep.is_some());
        assert!(in_world(&geometry(&strip(47))).sweep.is_none());
    }
}

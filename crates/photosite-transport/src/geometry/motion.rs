//! Motion of an instance, or of a light, over time.

use std::f64::consts::TAU;

use glam::{Affine3A, DAffine3, DMat3, DQuat, DVec3};

use super::bounds::Bounds;
use super::mesh::segment;
use super::word::{KEY_WORDS, Word, word};
use photosite_core::math::Cone;

/// A transform with its inverse.
#[derive(Clone, Copy, Debug)]
pub struct Transform {
    /// Object space → world.
    pub to_world: Affine3A,
    /// World → object space.
    pub to_object: Affine3A,
}

/// Parts of the way between two keys of a [`Motion`] that its bounds are taken over.
const STEPS: u16 = 8;

/// A way through transforms at evenly spaced times from 0 to 1.
///
/// Each is taken apart into M = R·S, the rotation next to it and a stretch. Between two of them the translation and S
/// go on straight lines and R turns at a constant rate on the shortest way
/// ([Shoemake85](photosite_core::references#shoemake85)), so that what is rigid stays so.
#[derive(Clone, Debug)]
pub struct Motion {
    keys: Vec<Key>,
}

#[derive(Clone, Copy, Debug)]
struct Key {
    translation: DVec3,
    rotation: DQuat,
    stretch: DMat3,
}

impl Transform {
    /// Inverts a transform, object → world.
    pub fn new(to_world: &DAffine3) -> Self {
        Self { to_world: single(to_world), to_object: single(&to_world.inverse()) }
    }
}

fn single(transform: &DAffine3) -> Affine3A {
    let [x, y, z] = [transform.matrix3.x_axis, transform.matrix3.y_axis, transform.matrix3.z_axis].map(|c| c.as_vec3());
    Affine3A::from_cols(x.into(), y.into(), z.into(), transform.translation.as_vec3().into())
}

impl Motion {
    /// Leads through at least two invertible transforms.
    pub fn new(transforms: &[DAffine3]) -> Self {
        let mut keys: Vec<Key> = transforms.iter().map(Key::new).collect();
        for i in 1..keys.len() {
            if keys[i].rotation.dot(keys[i - 1].rotation) < 0.0 {
                keys[i].rotation = -keys[i].rotation;
            }
        }
        Self { keys }
    }

    /// Object space → world at a time from 0 to 1.
    #[inline]
    pub fn to_world(&self, time: f64) -> DAffine3 {
        let segments = self.keys.len() - 1;
        let along = time * segments as f64;
        let i = (along as usize).min(segments - 1);
        self.between(i, along - i as f64)
    }

    /// The transform after a part, 0 to 1, of the way from the key of that number to the next.
    #[inline]
    fn between(&self, i: usize, part: f64) -> DAffine3 {
        let [a, b] = [&self.keys[i], &self.keys[i + 1]];
        let stretch = a.stretch * (1.0 - part) + b.stretch * part;
        DAffine3 {
            matrix3: DMat3::from_quat(a.rotation.slerp(b.rotation, part)) * stretch,
            translation: a.translation.lerp(b.translation, part),
        }
    }

    /// The transform at a time from 0 to 1, as rays have it.
    #[inline]
    pub fn at(&self, time: f32) -> Transform {
        let (i, part) = segment(time, self.keys.len() - 1);
        Transform::new(&self.between(i, f64::from(part)))
    }

    /// Number of parts of the time, each from one key to the next.
    pub(crate) fn segments(&self) -> u32 {
        (self.keys.len() - 1) as u32
    }

    /// The motion as plain data, [`KEY_WORDS`] for each key.
    pub(crate) fn words(&self) -> impl Iterator<Item = Word> + '_ {
        let next = self.keys.iter().skip(1).chain(self.keys.last());
        self.keys.iter().zip(next).flat_map(|(key, next)| key.words(next))
    }

    /// Bounds of everything within `min`…`max` of object space at all times.
    ///
    /// The way of a point is p = T + R·S·x. Between two times h apart it leaves the straight line by at most h²·|p″|/8,
    /// with |p″| ≤ ω²·|S·x| + 2ω·|ΔS·x| for a turn by ω from key to key.
    pub(crate) fn bounds(&self, (min, max): Bounds) -> Bounds {
        let corners: Vec<DVec3> = (0..8)
            .map(|i| DVec3::select(glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), max.into(), min.into()))
            .collect();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (i, pair) in self.keys.windows(2).enumerate() {
            let farthest = |m: DMat3| corners.iter().map(|c| (m * *c).length()).fold(0.0, f64::max);
            let turn = pair[0].rotation.angle_between(pair[1].rotation);
            let reach = farthest(pair[0].stretch).max(farthest(pair[1].stretch));
            let bend = turn * turn * reach + 2.0 * turn * farthest(pair[1].stretch - pair[0].stretch);
            let pad = bend / (8.0 * f64::from(STEPS * STEPS));
            for step in 0..=STEPS {
                let to_world = self.between(i, f64::from(step) / f64::from(STEPS));
                for corner in &corners {
                    let p = to_world.transform_point3(*corner);
                    (low, high) = (low.min(p - pad), high.max(p + pad));
                }
            }
        }
        (low.as_vec3(), high.as_vec3())
    }

    /// The directions that those of a cone in object space have at all times, where the motion is rigid.
    pub(crate) fn directions(&self, cone: Cone) -> Cone {
        let mut all: Option<Cone> = None;
        for (i, pair) in self.keys.windows(2).enumerate() {
            // Between two steps none is farther than half a step from the nearer one, and a rounding.
            let turn = pair[0].rotation.angle_between(pair[1].rotation) as f32 / f32::from(2 * STEPS) + 1e-5;
            for step in 0..=STEPS {
                let there = self.between(i, f64::from(step) / f64::from(STEPS));
                let axis = there.transform_vector3(cone.axis.as_dvec3()).normalize().as_vec3();
                let there = Cone { axis, ..cone }.widened(turn);
                all = Some(all.map_or(there, |all| all.union(there)));
            }
        }
        all.unwrap_or(Cone::ALL)
    }
}

impl Key {
    /// The key as plain data, with the turn to the next key: after a part s of the way, where α is the angle between
    /// both quaternions, the rotation is cos(s·α) times that of the first word plus sin(s·α) times that of the second.
    fn words(&self, next: &Self) -> [Word; KEY_WORDS] {
        let Self { translation, rotation, stretch } = *self;
        let cosine = rotation.dot(next.rotation);
        let across = next.rotation - rotation * cosine;
        let sine = across.length();
        let across = if sine > 0.0 { across / sine } else { across };
        let turns = sine.atan2(cosine) / TAU;
        let [x, y, z] = [stretch.x_axis, stretch.y_axis, stretch.z_axis];
        [
            rotation.as_quat().to_array().map(f32::to_bits),
            across.as_quat().to_array().map(f32::to_bits),
            word(translation.as_vec3(), (turns as f32).to_bits()),
            word(DVec3::new(x.x, y.y, z.z).as_vec3(), 0),
            word(DVec3::new(y.z, x.z, x.y).as_vec3(), 0),
        ]
    }

    /// Takes a transform apart into M = R·S by Higham's iteration R ← (R + R⁻ᵀ)/2. A mirror goes into S.
    fn new(transform: &DAffine3) -> Self {
        let m = transform.matrix3;
        let mut r = m;
        for _ in 0..100 {
            let next = (r + r.inverse().transpose()) * 0.5;
            let is_settled = next.abs_diff_eq(r, 1e-15);
            r = next;
            if is_settled {
                break;
            }
        }
        if r.determinant() < 0.0 {
            r *= -1.0;
        }
        Self {
            translation: transform.translation,
            rotation: DQuat::from_mat3(&r).normalize(),
            stretch: r.transpose() * m,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use glam::Vec3;

    use super::*;
    use photosite_core::math::cone::angle_between;

    fn turning_and_growing() -> [DAffine3; 2] {
        let shear = DMat3::from_cols(DVec3::new(1.0, 0.2, 0.0), DVec3::new(0.0, -2.0, 0.1), DVec3::Z);
        [0.0, 1.0].map(|t| DAffine3 {
            matrix3: DMat3::from_rotation_y(t * FRAC_PI_2) * shear * (1.0 + t),
            translation: DVec3::X * (3.0 * t),
        })
    }

    #[test]
    fn keys_are_passed_and_a_turn_keeps_its_rate() {
        let keys = turning_and_growing();
        let motion = Motion::new(&keys);
        for (time, key) in [0.0, 1.0].into_iter().zip(&keys) {
            assert!(motion.to_world(time).abs_diff_eq(*key, 1e-12), "{time}");
        }
        // A third of a quarter turn, and so of the way and of the growth.
        let rigid = [DMat3::IDENTITY, DMat3::from_rotation_z(FRAC_PI_2)].map(DAffine3::from_mat3);
        let third = Motion::new(&rigid).to_world(1.0 / 3.0);
        let expected = DMat3::from_rotation_z(FRAC_PI_2 / 3.0);
        assert!(third.matrix3.abs_diff_eq(expected, 1e-15), "{third}");
    }

    #[test]
    fn directions_hold_at_all_times() {
        let keys =
            [0.0, 0.8, 0.3].map(|t| DAffine3::from_quat(DQuat::from_rotation_y(t) * DQuat::from_rotation_x(2.0 * t)));
        let motion = Motion::new(&keys);
        let cone = Cone { axis: Vec3::new(0.6, 0.0, 0.8), angle: 0.1 };
        let all = motion.directions(cone);
        let mut reach = 0.0f32;
        for step in 0..=1000u16 {
            let axis = motion.at(f32::from(step) / 1000.0).to_world.transform_vector3(cone.axis);
            reach = reach.max(angle_between(axis, all.axis) + cone.angle);
        }
        assert!(reach <= all.angle, "{reach} {all:?}");
        // Half a step of a turn by some 2 rad, and what a cone of cones grows by.
        assert!(all.angle < reach + 0.3, "{reach} {all:?}");
    }

    #[test]
    fn bounds_hold_at_all_times() {
        let motion = Motion::new(&turning_and_growing());
        let (min, max) = (Vec3::new(-1.0, 0.0, 2.0), Vec3::new(0.5, 1.0, 3.0));
        let (low, high) = motion.bounds((min, max));
        let mut slack = Vec3::INFINITY;
        for step in 0..=1000u16 {
            let to_world = motion.at(f32::from(step) / 1000.0).to_world;
            for x in [min.x, max.x] {
                for y in [min.y, max.y] {
                    for z in [min.z, max.z] {
                        let p = to_world.transform_point3(Vec3::new(x, y, z));
                        assert!(p.cmpge(low - 1e-5).all() && p.cmple(high + 1e-5).all(), "{step}: {p}");
                        slack = slack.min(high - p);
                    }
                }
            }
        }
        // Not much wider than need be.
        assert!(slack.max_element() < 0.2, "{slack}");
    }
}

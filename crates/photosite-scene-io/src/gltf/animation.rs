//! Animations: transforms of nodes and weights of morph targets at a time (§3.11).

use glam::{DAffine3, DQuat};
use gltf::json::Root;
use gltf::json::animation::{Channel, Interpolation, Property, Sampler};
use gltf::json::scene::{Node, UnitQuaternion};
use gltf::json::validation::Checked;

use super::accessor::Accessors;
use super::buffers::out_of_range;
use super::document::NO_NODE;
use super::nodes::placed_nodes;
use photosite_core::Invalid;
use photosite_core::warnings::Warnings;

/// Time interval of an animation that an image is exposed to.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// Name of the animation; files without one of that name stand still.
    pub animation: String,
    /// Start, s of the animation.
    pub start_s: f64,
    /// Duration, s.
    pub duration_s: f64,
}

/// Largest number of parts that the interval of an image is divided into.
const MOST_PARTS: usize = 64;

/// Largest deviation of a transform from linear interpolation within a part, relative to the length of its axes, the
/// whole way of its origin, and the largest weight of a morph target. It is 1 − cos(2.6°): a body turns by at most 5°
/// in a part.
const TOLERANCE: f64 = 1e-3;

/// The names of a document's animations, in order.
pub(super) fn names(root: &Root) -> Vec<String> {
    let name = |(i, animation): (usize, &gltf::json::Animation)| {
        animation.name.clone().unwrap_or_else(|| format!("animation-{i}"))
    };
    root.animations.iter().enumerate().map(name).collect()
}

/// The nodes of a document at evenly spaced times from the start of a moment to its end, close enough together for
/// linear interpolation. Without a moment, or the animation that it names, there is one pose, that of the file.
pub(super) fn poses(
    accessors: Accessors<'_>,
    moment: Option<&Moment>,
    warnings: &mut Warnings,
) -> Result<Vec<Vec<Node>>, Invalid> {
    let root = accessors.root;
    let Some(moment) = moment else { return Ok(vec![root.nodes.clone()]) };
    let Some(index) = names(root).iter().position(|name| *name == moment.animation) else {
        return Ok(vec![root.nodes.clone()]);
    };
    let curves = curves(accessors, index, warnings)?;
    let at = |part: f64| {
        let mut nodes = root.nodes.clone();
        let time = moment.start_s + part * moment.duration_s;
        curves.iter().for_each(|curve| curve.apply(&mut nodes[curve.node], time));
        nodes
    };
    if moment.duration_s <= 0.0 {
        return Ok(vec![at(0.0)]);
    }
    let mut parts = 1;
    while parts < MOST_PARTS && !straight(root, &at, parts)? {
        parts *= 2;
    }
    Ok((0..=parts).map(|i| at(i as f64 / parts as f64)).collect())
}

/// Whether all nodes move linearly, near enough, between `parts` + 1 evenly spaced times.
fn straight(root: &Root, at: &impl Fn(f64) -> Vec<Node>, parts: usize) -> Result<bool, Invalid> {
    // Not all at even parts, where a swing could be taken for rest.
    const INNER: [f64; 3] = [0.31, 0.5, 0.77];
    let snapshot = |part: f64| -> Result<(Vec<DAffine3>, Vec<Vec<f32>>), Invalid> {
        let nodes = at(part);
        let places = placed_nodes(root, &nodes)?.iter().map(|placed| placed.to_world).collect();
        Ok((places, nodes.into_iter().map(|node| node.weights.unwrap_or_default()).collect()))
    };
    let keys = (0..=parts).map(|i| snapshot(i as f64 / parts as f64)).collect::<Result<Vec<_>, _>>()?;
    let nodes = keys[0].0.len();
    let way = |node: usize| -> f64 {
        keys.windows(2).map(|pair| pair[0].0[node].translation.distance(pair[1].0[node].translation)).sum()
    };
    let ways: Vec<f64> = (0..nodes).map(way).collect();
    for (i, pair) in keys.windows(2).enumerate() {
        for inner in INNER {
            let (places, weights) = snapshot((i as f64 + inner) / parts as f64)?;
            for (node, place) in places.iter().enumerate() {
                let [a, b] = [0, 1].map(|end: usize| pair[end].0[node]);
                let line = a.matrix3 * (1.0 - inner) + b.matrix3 * inner;
                let bends = (0..3).any(|axis| {
                    let length = place.matrix3.col(axis).length();
                    (place.matrix3.col(axis) - line.col(axis)).length() > TOLERANCE * length
                });
                let off = place.translation.distance(a.translation.lerp(b.translation, inner));
                // The numbers of a file are of single precision.
                let rounding = f64::from(f32::EPSILON) * 4.0 * place.translation.abs().max_element();
                if bends || off > TOLERANCE * ways[node] + rounding {
                    return Ok(false);
                }
            }
            for (node, weights) in weights.iter().enumerate() {
                let [a, b] = [0, 1].map(|end: usize| &pair[end].1[node]);
                for ((weight, a), b) in weights.iter().zip(a).zip(b) {
                    let line = f64::from(*a) * (1.0 - inner) + f64::from(*b) * inner;
                    let largest = f64::from(a.abs().max(b.abs()).max(weight.abs()));
                    if (f64::from(*weight) - line).abs() > TOLERANCE * largest {
                        return Ok(false);
                    }
                }
            }
        }
    }
    Ok(true)
}

/// A property of a node over time.
struct Curve {
    node: usize,
    property: Property,
    interpolation: Interpolation,
    /// Times of the keyframes, s, rising.
    times: Vec<f64>,
    /// Values, `width` numbers for each time; for a cubic spline three times as many: tangent in, value, tangent out.
    values: Vec<f64>,
    width: usize,
}

fn curves(accessors: Accessors<'_>, index: usize, warnings: &mut Warnings) -> Result<Vec<Curve>, Invalid> {
    let root = accessors.root;
    let animation = &root.animations[index];
    let mut curves = Vec::with_capacity(animation.channels.len());
    for (i, channel) in animation.channels.iter().enumerate() {
        let key = format!("animations[{index}].channels[{i}]");
        if channel.target.node.value() == NO_NODE {
            continue;
        }
        let Checked::Valid(property) = channel.target.path else {
            warnings.once("animated properties other than translation, rotation, scale and weights stand still");
            continue;
        };
        let at = channel.sampler.value();
        let sampler = animation
            .samplers
            .get(at)
            .ok_or_else(|| out_of_range(&format!("{key}.sampler"), "samplers", at, animation.samplers.len()))?;
        curves.push(curve(
            accessors,
            channel,
            property,
            sampler,
            &key,
            &format!("animations[{index}].samplers[{at}]"),
        )?);
    }
    Ok(curves)
}

fn curve(
    accessors: Accessors<'_>,
    channel: &Channel,
    property: Property,
    sampler: &Sampler,
    key: &str,
    sampler_key: &str,
) -> Result<Curve, Invalid> {
    let root = accessors.root;
    let node = channel.target.node.value();
    let target = root
        .nodes
        .get(node)
        .ok_or_else(|| out_of_range(&format!("{key}.target.node"), "nodes", node, root.nodes.len()))?;
    if target.matrix.is_some() && !matches!(property, Property::MorphTargetWeights) {
        let message = format!("moves nodes[{node}], which has a matrix");
        let help = "a node that is animated needs translation, rotation and scale instead";
        return Err(Invalid::new(format!("{key}.target"), message).help(help));
    }
    let Checked::Valid(interpolation) = sampler.interpolation else {
        let invalid = Invalid::new(format!("{sampler_key}.interpolation"), "is unknown");
        return Err(invalid.help("write LINEAR, STEP or CUBICSPLINE"));
    };
    let input_key = format!("{sampler_key}.input");
    let times: Vec<f64> =
        accessors.floats::<1>(sampler.input.value(), &input_key)?.into_iter().map(|[t]| f64::from(t)).collect();
    if times.is_empty() || times.iter().any(|t| !t.is_finite()) || times.windows(2).any(|pair| pair[1] <= pair[0]) {
        let help = "times are finite, in seconds, each after the last; export the animation again";
        return Err(Invalid::new(input_key, "holds times that do not rise").help(help));
    }
    let (output, output_key) = (sampler.output.value(), format!("{sampler_key}.output"));
    let flat = |values: Vec<f32>| values.into_iter().map(f64::from).collect::<Vec<_>>();
    let (values, width) = match property {
        Property::Translation | Property::Scale => (flat(accessors.floats::<3>(output, &output_key)?.concat()), 3),
        Property::Rotation => (flat(accessors.floats::<4>(output, &output_key)?.concat()), 4),
        Property::MorphTargetWeights => {
            let values = flat(accessors.floats::<1>(output, &output_key)?.concat());
            let width = values.len() / (times.len() * per_time(interpolation)).max(1);
            (values, width)
        }
    };
    let expected = times.len() * width * per_time(interpolation);
    if values.len() != expected || width == 0 {
        let message = format!("holds {} numbers for {} times", values.len(), times.len());
        return Err(Invalid::new(output_key, message).help("export the animation again"));
    }
    if let Some(i) = values.iter().position(|v| !v.is_finite()) {
        return Err(Invalid::new(output_key, format!("number {i} is not finite: {}", values[i])));
    }
    Ok(Curve { node, property, interpolation, times, values, width })
}

/// Number of values for each time.
fn per_time(interpolation: Interpolation) -> usize {
    match interpolation {
        Interpolation::Linear | Interpolation::Step => 1,
        Interpolation::CubicSpline => 3,
    }
}

impl Curve {
    fn apply(&self, node: &mut Node, time: f64) {
        let value = self.at(time);
        let vector = |v: &[f64]| [0, 1, 2].map(|i| v[i] as f32);
        match self.property {
            Property::Translation => node.translation = Some(vector(&value)),
            Property::Scale => node.scale = Some(vector(&value)),
            Property::Rotation => node.rotation = Some(UnitQuaternion([0, 1, 2, 3].map(|i| value[i] as f32))),
            Property::MorphTargetWeights => node.weights = Some(value.iter().map(|w| *w as f32).collect()),
        }
    }

    /// Value at a time; before the first and after the last keyframe it is constant (Appendix C of the specification).
    fn at(&self, time: f64) -> Vec<f64> {
        let next = self.times.partition_point(|t| *t <= time);
        let (Some(from), Some(to)) = (next.checked_sub(1), (next < self.times.len()).then_some(next)) else {
            return self.value(next.saturating_sub(1), 1).to_vec();
        };
        let span = self.times[to] - self.times[from];
        let t = (time - self.times[from]) / span;
        let (a, b) = (self.value(from, 1), self.value(to, 1));
        match (self.interpolation, self.property) {
            (Interpolation::Step, _) => a.to_vec(),
            (Interpolation::Linear, Property::Rotation) => {
                let [a, b] = [a, b].map(|q| DQuat::from_slice(q).normalize());
                a.slerp(b, t).to_array().to_vec()
            }
            (Interpolation::Linear, Property::Translation | Property::Scale | Property::MorphTargetWeights) => {
                a.iter().zip(b).map(|(a, b)| a * (1.0 - t) + b * t).collect()
            }
            (Interpolation::CubicSpline, _) => {
                let (out, into) = (self.value(from, 2), self.value(to, 0));
                let (t2, t3) = (t * t, t * t * t);
                (0..self.width)
                    .map(|i| {
                        (2.0 * t3 - 3.0 * t2 + 1.0) * a[i]
                            + span * (t3 - 2.0 * t2 + t) * out[i]
                            + (3.0 * t2 - 2.0 * t3) * b[i]
                            + span * (t3 - t2) * into[i]
                    })
                    .collect()
            }
        }
    }

    /// Numbers of a keyframe; of a cubic spline those of its `part`.
    fn value(&self, index: usize, part: usize) -> &[f64] {
        let first = match self.interpolation {
            Interpolation::Linear | Interpolation::Step => index,
            Interpolation::CubicSpline => 3 * index + part,
        } * self.width;
        &self.values[first..first + self.width]
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn curve(property: Property, interpolation: Interpolation, values: &[f64], width: usize) -> Curve {
        Curve { node: 0, property, interpolation, times: vec![1.0, 3.0], values: values.to_vec(), width }
    }

    #[test]
    fn curves_pass_their_values_and_stay_at_their_ends() {
        let linear = curve(Property::Translation, Interpolation::Linear, &[0.0, 1.0, 2.0, 4.0, 1.0, -2.0], 3);
        for (time, expected) in
            [(0.0, [0.0, 1.0, 2.0]), (1.5, [1.0, 1.0, 1.0]), (3.0, [4.0, 1.0, -2.0]), (9.0, [4.0, 1.0, -2.0])]
        {
            assert_eq!(linear.at(time), expected, "{time}");
        }
        let step = curve(Property::MorphTargetWeights, Interpolation::Step, &[0.25, 0.75], 1);
        assert_eq!([0.0, 2.9, 3.0].map(|t| step.at(t)[0]), [0.25, 0.25, 0.75]);
        // Of the parabola y = (t − 1)² with its derivatives 0 and 4: Hermite's cubic is exact.
        let cubic = curve(Property::MorphTargetWeights, Interpolation::CubicSpline, &[0.0, 0.0, 0.0, 4.0, 4.0, 0.0], 1);
        for time in [1.0, 1.3, 2.0, 2.9] {
            assert!((cubic.at(time)[0] - (time - 1.0f64).powi(2)).abs() < 1e-12, "{time}");
        }
    }

    #[test]
    fn rotations_turn_at_a_constant_rate_on_the_shortest_way() {
        let end = DQuat::from_axis_angle(DVec3::Z, 1.2);
        let values = [DQuat::IDENTITY.to_array(), (-end).to_array()].concat();
        let found = curve(Property::Rotation, Interpolation::Linear, &values, 4).at(1.5);
        let expected = DQuat::from_axis_angle(DVec3::Z, 0.3);
        assert!(DQuat::from_slice(&found).dot(expected).abs() > 1.0 - 1e-12);
    }
}

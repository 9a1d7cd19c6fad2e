//! The point that lights are sampled from.

use glam::{Vec3, Vec3A};

use super::bounds::Cluster;

/// A point that lights are sampled from, and the directions that matter to it; `LightSampleContext` in
/// [pbrt4](photosite_core::references#pbrt4) §12.1.
#[derive(Clone, Copy, Debug)]
pub struct LightSampleContext {
    /// Position of the point, m.
    pub point: Vec3,
    /// The sides from which light matters.
    pub facing: Facing,
}

/// The sides from which a point receives light.
#[derive(Clone, Copy, Debug)]
pub enum Facing {
    /// Side of a unit normal, weighted by the cosine to it: surfaces that only reflect.
    Front(Vec3),
    /// Both sides of a unit normal, weighted by the cosine to it: surfaces that also transmit.
    Both(Vec3),
    /// All directions alike.
    Anywhere,
}

impl LightSampleContext {
    /// A point that takes light from all directions.
    pub const fn anywhere(point: Vec3) -> Self {
        Self { point, facing: Facing::Anywhere }
    }

    /// An estimate of the irradiance from lights within bounds, in relative units; 0 only where none of them can reach
    /// the point:
    ///
    ///   Φ·cos θ′·cos θᵢ′ / max(d², r²),
    ///
    /// with Φ the intensity of all together, d the distance of the middle of their box, r half its diagonal, and the
    /// smallest angles at the light, θ′, and at the point, θᵢ′, that any light within the box could have
    /// ([pbrt4](photosite_core::references#pbrt4) §12.6.3, `LightBounds::Importance`). There the angles are bounded by
    /// a sphere about the box, within which all are possible; here cos θᵢ′ is the largest height of the box over the
    /// surface over its smallest distance, and cos θ′ alike. So a ceiling of lights counts for those that are near,
    /// large as its box may be.
    #[inline]
    pub(super) fn importance(&self, cluster: &Cluster) -> f32 {
        let to_centre = cluster.centre - Vec3A::from(self.point);
        let aside = to_centre.abs();
        let nearest2 = (aside - cluster.half).max(Vec3A::ZERO).length_squared();
        let farthest2 = (aside + cluster.half).length_squared();
        // Cosine to an axis of the direction that goes farthest along it.
        let cosine = |along: f32, spread: f32| {
            let most = along + spread;
            if most >= 0.0 && most * most >= nearest2 {
                1.0
            } else {
                most / if most > 0.0 { nearest2 } else { farthest2 }.sqrt()
            }
        };

        let along = -cluster.axis.dot(to_centre);
        let along = if cluster.two_sided { along.abs() } else { along };
        let cos_axis = cosine(along, cluster.axis.abs().dot(cluster.half));
        let at_light = if cos_axis >= cluster.cos_cone {
            1.0
        } else {
            let sines = (1.0 - cos_axis * cos_axis) * (1.0 - cluster.cos_cone * cluster.cos_cone);
            cos_axis * cluster.cos_cone + sines.max(0.0).sqrt()
        };
        if at_light < cluster.cos_beyond {
            return 0.0;
        }
        let at_receiver = match self.facing {
            Facing::Front(normal) => {
                let normal = Vec3A::from(normal);
                cosine(normal.dot(to_centre), normal.abs().dot(cluster.half)).max(0.0)
            }
            Facing::Both(normal) => {
                let normal = Vec3A::from(normal);
                cosine(normal.dot(to_centre).abs(), normal.abs().dot(cluster.half))
            }
            Facing::Anywhere => 1.0,
        };
        let distance2 = to_centre.length_squared().max(cluster.half.length_squared());
        cluster.intensity * at_light * at_receiver / distance2.max(NEAREST2)
    }
}

/// Squares of smaller distances, m², count as this one, so that importances stay finite.
const NEAREST2: f32 = 1e-30;

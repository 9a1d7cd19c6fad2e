//! The rigid-body engine, rapier: objects under gravity, first as convex parts that fall, then as exact meshes that settle.

use parry3d_f64::bounding_volume::{Aabb, BoundingVolume};
use parry3d_f64::math::{Pose3, Vector};
use parry3d_f64::shape::{SharedShape, TriMesh};
use rapier3d_f64::prelude::{
    ColliderBuilder, FrictionModel, MassProperties, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle,
};

use crate::body::Body;
use crate::hull::Hull;
use crate::pose::Pose;
use crate::request::Contact;

/// Units of the engine's length per metre: the engine keeps the direction of a contact while its points move by less
/// than 0.001 units, by which a corner slides off an edge where units are metres.
const UNITS: f64 = 1000.0;
/// Gravity of the Earth, m/s².
const GRAVITY: f64 = 9.80665;
/// Gap that the engine keeps between touching objects, m: they may sink into each other by this much and still not
/// meet.
const GAP_M: f64 = 4e-5;
/// Damping of all motion while objects settle, 1/s, at first and then. An object that is not held moves at its
/// acceleration divided by this.
const VISCOSITY: [f64; 2] = [200.0, 30.0];
/// Time over which movements are measured, s.
const WINDOW_S: f64 = 0.1;
/// Largest movement of a settled object in that time, m: what holds it then takes all but a thousandth of its weight.
const STILL_M: f64 = 1e-5;
/// Largest movement of a fallen object in that time, relative to its size, and the time limits of falling and of
/// settling, s.
const SLOW: f64 = 0.002;
const LONGEST_FALL_S: f64 = 8.0;
const LONGEST_SETTLING_S: f64 = 1.2;
/// Smallest mass of an object relative to the heaviest: below it, the engine does not find the forces of what lies on
/// it.
const LIGHTEST: f64 = 0.03;

/// Fixed objects, ground and contact parameters around the moving objects.
pub(crate) struct Surroundings<'a> {
    pub(crate) fixed: &'a [(Body, Pose)],
    pub(crate) ground_height: Option<f64>,
    pub(crate) contact: Contact,
}

/// A run of the engine.
struct Run {
    world: PhysicsWorld,
    handles: Vec<RigidBodyHandle>,
    /// Size of each object, m.
    radii: Vec<f64>,
}

/// Parameters of a run.
struct Manner {
    time_step: f64,
    /// Gap between touching objects, and distance at which they detect each other, m.
    gap: f64,
    prediction: f64,
    damping: [f64; 2],
    fastest: f64,
    restitution: f64,
    is_exact: bool,
}

/// Drops objects until they are nearly at rest. Their convex parts stay apart by a hundredth of the size of the
/// smallest, so that their meshes do not meet.
pub(crate) fn fall(surroundings: &Surroundings<'_>, bodies: &[Body], poses: &[Pose]) -> Vec<Pose> {
    let smallest = bodies.iter().map(|body| body.radius).fold(f64::INFINITY, f64::min);
    let manner = Manner {
        // A small part of the time in which the smallest falls its own size.
        time_step: ((smallest / GRAVITY).sqrt() / 20.0).clamp(1.0 / 2000.0, 1.0 / 240.0),
        gap: (0.01 * smallest).max(GAP_M),
        prediction: 0.04 * smallest,
        // What rolls comes to rest, too.
        damping: [0.2, 2.0],
        fastest: 100.0,
        restitution: surroundings.contact.restitution,
        is_exact: false,
    };
    let parts = |body: &Body| body.shape.parts().iter().filter_map(|part| convex(part, body)).collect();
    let shapes: Vec<Vec<SharedShape>> = bodies.iter().map(parts).collect();
    let mut run = Run::new(surroundings, bodies, poses, &shapes, &manner);
    let mut time = 0.0;
    while time < LONGEST_FALL_S {
        let moved = run.advance(WINDOW_S);
        time += WINDOW_S;
        // At first things only begin to fall.
        let is_slow = moved.iter().zip(&run.radii).all(|(moved, radius)| *moved <= SLOW * radius);
        if time > 2.0 * WINDOW_S && is_slow {
            break;
        }
    }
    run.poses()
}

/// Lets objects that do not meet settle as through honey, with their triangles, until their supports take their weight.
/// `None` where they do not come to rest.
pub(crate) fn settle(surroundings: &Surroundings<'_>, bodies: &[Body], poses: &[Pose]) -> Option<Vec<Pose>> {
    let largest = bodies.iter().map(|body| body.radius).fold(0.0, f64::max);
    // Triangles that are farther than this from everything are left out until something moved half as far.
    let margin = 0.001 + 0.04 * largest;
    let mut poses = poses.to_vec();
    let mut time = 0.0;
    while time < LONGEST_SETTLING_S {
        let viscosity = VISCOSITY[usize::from(time > 1.5 * WINDOW_S)];
        let manner = Manner {
            time_step: 1.0 / 240.0,
            gap: GAP_M,
            prediction: 2.5e-4,
            damping: [viscosity; 2],
            fastest: 2.5e-4 * 240.0,
            restitution: 0.0,
            is_exact: true,
        };
        let shapes = near_triangles(surroundings, bodies, &poses, margin);
        let mut run = Run::new(surroundings, bodies, &poses, &shapes, &manner);
        let mut way = vec![0.0; bodies.len()];
        let mut is_first = time == 0.0;
        while way.iter().all(|way| *way < margin / 2.0) && time < LONGEST_SETTLING_S {
            let moved = run.advance(WINDOW_S);
            time += WINDOW_S;
            if moved.iter().all(|moved| *moved <= STILL_M) {
                return Some(run.poses());
            }
            way.iter_mut().zip(&moved).for_each(|(way, moved)| *way += moved);
            if std::mem::take(&mut is_first) {
                break;
            }
        }
        poses = run.poses();
    }
    None
}

/// Triangles of each object that are near to another object or to the surroundings.
fn near_triangles(
    surroundings: &Surroundings<'_>,
    bodies: &[Body],
    poses: &[Pose],
    margin: f64,
) -> Vec<Vec<SharedShape>> {
    let of = |i: usize| {
        let (body, pose) = (&bodies[i], &poses[i]);
        let others = (bodies.iter().zip(poses).enumerate()).filter(|(j, _)| *j != i).map(|(_, other)| other);
        let bounds = body.bounds(pose).loosened(margin);
        let others: Vec<(&Body, Pose3)> = others
            .chain(surroundings.fixed.iter().map(|(other, at)| (other, at)))
            .filter(|(other, at)| other.bounds(at).intersects(&bounds))
            .map(|(other, at)| (other, at.to_parry().inverse() * pose.to_parry()))
            .collect();
        let up = pose.rotation.inverse() * glam::DVec3::Y;
        let is_near = |t: &[u32; 3]| {
            let corners = t.map(|v| body.mesh.vertices()[v as usize]);
            let is_low = surroundings.ground_height.is_some_and(|height| {
                corners.iter().any(|p| up.dot(crate::pose::point(*p)) + pose.position.y <= height + margin)
            });
            is_low
                || others.iter().any(|(other, to_other)| {
                    let corners = corners.map(|p| *to_other * p);
                    let around = Aabb::from_points(corners).loosened(margin);
                    other.mesh.bvh().intersect_aabb(&around).next().is_some()
                })
        };
        let triangles: Vec<[u32; 3]> = body.mesh.indices().iter().filter(|t| is_near(t)).copied().collect();
        // Vertices that are left over do no harm.
        let vertices = body.mesh.vertices().iter().map(|p| *p * UNITS).collect();
        let mesh = TriMesh::new(vertices, triangles);
        mesh.into_iter().map(SharedShape::new).collect()
    };
    (0..bodies.len()).map(of).collect()
}

impl Run {
    fn new(
        surroundings: &Surroundings<'_>,
        bodies: &[Body],
        poses: &[Pose],
        shapes: &[Vec<SharedShape>],
        manner: &Manner,
    ) -> Self {
        let mut world = PhysicsWorld { gravity: Vector::Y * (-GRAVITY * UNITS), ..PhysicsWorld::default() };
        let size = 2.0 * bodies.iter().map(|body| body.radius).fold(f64::INFINITY, f64::min);
        let parameters = &mut world.integration_parameters;
        parameters.dt = manner.time_step;
        parameters.length_unit = size * UNITS;
        parameters.normalized_prediction_distance = manner.prediction / size;
        // As stiff as four iterations a step allow: little sinking under load.
        parameters.num_solver_iterations = 4;
        parameters.contact_softness.natural_frequency = 1.0 / manner.time_step;
        parameters.static_contact_softness.natural_frequency = 1.0 / manner.time_step;
        parameters.friction_model = FrictionModel::Coulomb;
        parameters.normalized_max_linear_velocity = manner.fastest / size;
        // Contacts are found anew in each step, and of exact meshes all count.
        parameters.contact_recycling = false;
        parameters.contact_clustering = !manner.is_exact;
        let collider = |shape: SharedShape| {
            ColliderBuilder::new(shape)
                .density(0.0)
                .friction(surroundings.contact.friction)
                .restitution(manner.restitution)
                .contact_skin(manner.gap / 2.0 * UNITS)
        };
        if let Some(height) = surroundings.ground_height {
            world.insert_collider(
                collider(SharedShape::halfspace(Vector::Y)).translation(Vector::Y * (height * UNITS)),
                None,
            );
        }
        for (body, pose) in surroundings.fixed {
            let is_solid = !manner.is_exact && body.shape.is_convex();
            let solid = is_solid.then(|| convex(&body.shape.hull, body)).flatten();
            let exact = || SharedShape::new(TriMesh::clone(&body.mesh).scaled(Vector::splat(UNITS)));
            let shape = solid.unwrap_or_else(exact);
            world.insert_collider(collider(shape).position(in_units(pose)), None);
        }
        let mut handles = Vec::new();
        let heaviest = bodies.iter().map(|body| mass(body).mass()).fold(0.0, f64::max);
        for ((body, pose), shapes) in bodies.iter().zip(poses).zip(shapes) {
            let mut mass = mass(body);
            mass.set_mass(mass.mass().max(LIGHTEST * heaviest), true);
            let moving = RigidBodyBuilder::dynamic()
                .pose(in_units(pose))
                .can_sleep(false)
                .additional_mass_properties(mass)
                .linear_damping(manner.damping[0])
                .angular_damping(manner.damping[1]);
            let handle = world.insert_body(moving);
            for shape in shapes {
                world.insert_collider(collider(shape.clone()), Some(handle));
            }
            handles.push(handle);
        }
        Self { world, handles, radii: bodies.iter().map(|body| body.radius).collect() }
    }

    /// Advances the engine by a time; returns the movement of each object, of its farthest point at most, m.
    fn advance(&mut self, seconds: f64) -> Vec<f64> {
        let before = self.poses3();
        let steps = (seconds / self.world.integration_parameters.dt).ceil() as usize;
        (0..steps).for_each(|_| self.world.step());
        let moved = |((before, after), radius): ((&Pose3, &Pose3), &f64)| {
            let turned = before.rotation.inverse() * after.rotation;
            let [x, y, z, _] = turned.to_array();
            let way = (after.translation - before.translation).length() / UNITS;
            way + 2.0 * radius * (x * x + y * y + z * z).sqrt()
        };
        before.iter().zip(&self.poses3()).zip(&self.radii).map(moved).collect()
    }

    fn poses3(&self) -> Vec<Pose3> {
        self.handles.iter().map(|handle| *self.world.bodies[*handle].position()).collect()
    }

    fn poses(&self) -> Vec<Pose> {
        let in_metres = |pose: Pose3| Pose::from_parry(&Pose3 { translation: pose.translation / UNITS, ..pose });
        self.poses3().into_iter().map(in_metres).collect()
    }
}

fn in_units(pose: &Pose) -> Pose3 {
    let pose = pose.to_parry();
    Pose3 { translation: pose.translation * UNITS, ..pose }
}

fn convex(part: &Hull, body: &Body) -> Option<SharedShape> {
    SharedShape::convex_mesh(part.points.iter().map(|p| *p * (body.scale * UNITS)).collect(), &part.triangles)
}

/// Mass, centre and inertia of an object at its scale and density, in the engine's units and kg.
fn mass(body: &Body) -> MassProperties {
    let unit = &body.shape.mass;
    MassProperties::with_principal_inertia_frame(
        unit.local_com * (body.scale * UNITS),
        unit.mass() * body.scale.powi(3) * body.density,
        unit.principal_inertia() * (body.scale.powi(5) * UNITS.powi(2) * body.density),
        unit.principal_inertia_local_frame,
    )
}

//! A thin owner of one Rapier world: builds bodies, steps, and reads back what the report needs.
//!
//! Settings are Rapier's defaults, which are Box3D's too: 4 substeps with one solving and one relaxing iteration,
//! contacts of 30 Hz ζ 10 (60 Hz on what is fixed), pushed out at up to 3 m/s, speeds up to 400 m/s, sleeping below
//! 0.05 m/s after 0.5 s, continuous collision of what moves against what is fixed. Joints are as stiff as Rapier
//! makes them: with Box3D's 60 Hz ζ 2 `joint_grid` takes as long and sags by 8.4 m in 100 steps, Box3D's by 0.3 m.
//!
//! What cannot be said in Rapier: rolling resistance; a cone (each swing has a range of its own instead); friction
//! in a joint that has a spring; groups of ragdolls beyond 32 (one bit serves several cells, 45 m apart).

use crate::shared::human::{Hold, REST_SPRING};
use crate::shared::parts::{
    BodyOptions, Capacity, DT_S, Frame, Kind, Limb, Meets, SUBSTEPS, Shape, ShapeOptions, V,
};
use rapier3d::prelude::*;
use std::f32::consts::PI;

/// A body of the world.
pub type Body = RigidBodyHandle;

fn quat([x, y, z, w]: [f32; 4]) -> Rotation {
    Rotation::from_xyzw(x, y, z, w).normalize()
}

fn pose((p, q): Frame) -> Pose {
    Pose::from_parts(Vector::from(p), quat(q))
}

/// A frame whose main axis is x, as Rapier has it, of one whose main axis is z.
fn main_axis_first((p, q): Frame) -> Pose {
    Pose::from_parts(Vector::from(p), quat(q) * Rotation::from_rotation_arc(Vector::X, Vector::Z))
}

/// A convex hull.
pub struct Hull(SharedShape);

impl Hull {
    /// The hull of `points` (metres, body frame); says so where Rapier refuses them.
    pub fn new(points: &[V]) -> Result<Hull, String> {
        let points: Vec<Vector> = points.iter().copied().map(Vector::from).collect();
        let hull = SharedShape::convex_hull(&points);
        hull.map(Hull).ok_or(format!("Rapier built no hull from {} points", points.len()))
    }
}

/// A mesh of counter-clockwise triangles, shared between bodies.
pub struct Mesh(SharedShape);

impl Mesh {
    /// The mesh of `triangles` over `points` (metres, body frame), which smooths contacts on its inner edges.
    pub fn new(points: &[V], triangles: &[[u32; 3]]) -> Result<Mesh, String> {
        let points = points.iter().copied().map(Vector::from).collect();
        let mesh =
            SharedShape::trimesh_with_flags(points, triangles.to_vec(), TriMeshFlags::FIX_INTERNAL_EDGES);
        mesh.map(Mesh).map_err(|e| e.to_string())
    }
}

/// One Rapier world with the bodies the scene created, in creation order.
pub struct World {
    world: PhysicsWorld,
    can_sleep: bool,
    /// Bodies made so far that move, those removed again among them.
    dynamic: Vec<Body>,
}

impl World {
    /// A world with Rapier's defaults, gravity along y in m/s² and `threads` workers. Rapier takes no capacities.
    pub fn new(threads: u32, gravity_y: f32, _: Capacity) -> Result<World, String> {
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::new(0.0, gravity_y, 0.0);
        world.integration_parameters.dt = DT_S;
        world.integration_parameters.num_solver_iterations = SUBSTEPS as usize;
        #[cfg(feature = "parallel")]
        world.configure_thread_pool(threads as usize).map_err(|e| e.to_string())?;
        #[cfg(not(feature = "parallel"))]
        let _ = threads;
        Ok(World { world, can_sleep: true, dynamic: Vec::new() })
    }

    /// Keeps every body made from now on awake.
    pub fn disable_sleep(&mut self) {
        self.can_sleep = false;
    }

    /// Creates a body without shapes.
    pub fn body(&mut self, options: &BodyOptions) -> Body {
        let builder = match options.kind {
            Kind::Fixed => RigidBodyBuilder::fixed(),
            Kind::Kinematic => RigidBodyBuilder::kinematic_velocity_based(),
            Kind::Dynamic => RigidBodyBuilder::dynamic(),
        };
        let mut body = builder
            .pose(pose(options.frame))
            .linvel(Vector::from(options.velocity))
            .angvel(Vector::from(options.spin))
            .can_sleep(options.can_sleep && self.can_sleep)
            .build();
        if options.can_sleep && self.can_sleep {
            body.activation_mut().normalized_linear_threshold = options.sleep_speed;
        }
        let handle = self.world.insert_body(body);
        if options.kind == Kind::Dynamic {
            self.dynamic.push(handle);
        }
        handle
    }

    /// Destroys a body with its shapes and joints.
    pub fn remove(&mut self, body: Body) {
        self.world.remove_body(body);
    }

    fn collider(&mut self, body: Body, builder: ColliderBuilder, options: ShapeOptions) {
        let only = |bit: u32| Group::from_bits_truncate(1 << bit);
        let but = |own: Group| InteractionGroups::new(own, Group::ALL & !own, InteractionTestMode::And);
        let groups = match options.meets {
            Meets::All => InteractionGroups::all(),
            Meets::NotGhosts => but(only(31)),
            Meets::NotGroup(group) => but(only(group % 30)),
        };
        let collider = builder
            .density(options.density)
            .friction(options.friction)
            .friction_combine_rule(CoefficientCombineRule::GeometricMean)
            .restitution(options.restitution)
            .restitution_combine_rule(CoefficientCombineRule::Max)
            .collision_groups(groups);
        self.world.insert_collider(collider, Some(body));
    }

    /// Attaches a shape to a body of this world.
    pub fn shape(&mut self, body: Body, shape: &Shape, options: ShapeOptions) {
        let builder = match shape {
            Shape::Box { half: [x, y, z], centre } => {
                ColliderBuilder::cuboid(*x, *y, *z).translation(Vector::from(*centre))
            }
            Shape::Sphere { radius } => ColliderBuilder::ball(*radius),
            Shape::Capsule { a, b, radius } => {
                ColliderBuilder::capsule_from_endpoints(Vector::from(*a), Vector::from(*b), *radius)
            }
            Shape::Hull(hull) => ColliderBuilder::new(hull.0.clone()),
        };
        self.collider(body, builder, options);
    }

    /// Attaches a mesh to a fixed body.
    pub fn mesh(&mut self, body: Body, mesh: &Mesh, options: ShapeOptions) {
        self.collider(body, ColliderBuilder::new(mesh.0.clone()), options);
    }

    /// Where the centre of mass is, in the body's frame.
    pub fn local_center(&mut self, body: Body) -> V {
        let body = &mut self.world.bodies[body];
        body.recompute_mass_properties_from_colliders(&self.world.colliders);
        body.local_center_of_mass().into()
    }

    /// Sets the velocity of the centre of mass, m/s, and the spin, rad/s.
    pub fn set_velocity(&mut self, body: Body, v: V, w: V) {
        let body = &mut self.world.bodies[body];
        body.set_linvel(Vector::from(v), true);
        body.set_angvel(Vector::from(w), true);
    }

    /// Holds a point of A to a point of B, each in its body's frame; turning is free.
    pub fn ball_joint(&mut self, a: (Body, V), b: (Body, V)) {
        let joint = SphericalJointBuilder::new()
            .local_anchor1(Vector::from(a.1))
            .local_anchor2(Vector::from(b.1))
            .contacts_enabled(false);
        self.world.insert_impulse_joint(a.0, b.0, joint);
    }

    /// Joins two bones with limits and a spring to their rest. The spring takes the place of the motor that stands
    /// for friction elsewhere.
    pub fn limb(&mut self, limb: &Limb) {
        let omega = 2.0 * PI * REST_SPRING.0;
        let (stiffness, damping) = (omega * omega, 2.0 * REST_SPRING.1 * omega);
        let turn = |joint: GenericJointBuilder, axis, lo: f32, hi: f32| {
            let joint = joint.limits(axis, [lo.to_radians(), hi.to_radians()]);
            joint.motor_position(axis, 0.0, stiffness, damping)
        };
        let joint = |locked| {
            GenericJointBuilder::new(locked)
                .local_frame1(main_axis_first(limb.frame_a))
                .local_frame2(main_axis_first(limb.frame_b))
                .contacts_enabled(false)
        };
        let joint = match limb.hold {
            Hold::Root => return,
            Hold::Ball(cone, lo, hi) => {
                let joint = turn(joint(JointAxesMask::LOCKED_SPHERICAL_AXES), JointAxis::AngX, lo, hi);
                let joint = turn(joint, JointAxis::AngY, -cone, cone);
                turn(joint, JointAxis::AngZ, -cone, cone)
            }
            Hold::Hinge(lo, hi) => turn(joint(JointAxesMask::LOCKED_REVOLUTE_AXES), JointAxis::AngX, lo, hi),
        };
        self.world.insert_impulse_joint(limb.a, limb.b, joint);
    }

    /// Keeps two bodies from touching each other: a joint that holds nothing.
    pub fn pass_through(&mut self, a: Body, b: Body) {
        let joint = GenericJointBuilder::new(JointAxesMask::empty()).contacts_enabled(false);
        self.world.insert_impulse_joint(a, b, joint);
    }

    /// Gives a kinematic body the velocity that reaches the position, unturned, in one step.
    pub fn move_to(&mut self, body: Body, x: f32, y: f32, z: f32) {
        let body = &mut self.world.bodies[body];
        let way = Vector::new(x, y, z) - body.translation();
        body.set_linvel(way / DT_S, true);
    }

    /// One step of `DT_S` with `SUBSTEPS` substeps.
    pub fn step(&mut self) {
        self.world.step();
    }

    /// Number of all bodies.
    pub fn body_count(&self) -> usize {
        self.world.bodies.len()
    }

    fn moving(&self) -> impl Iterator<Item = &RigidBody> {
        self.dynamic.iter().filter_map(|&body| self.world.bodies.get(body))
    }

    /// Heights of the dynamic bodies in creation order, in metres.
    pub fn dynamic_heights(&self) -> Vec<f32> {
        self.moving().map(|body| body.translation().y).collect()
    }

    /// Greatest speed of a dynamic body, in m/s.
    pub fn speed_max(&self) -> f32 {
        self.moving().map(|body| body.linvel().length()).fold(0.0, f32::max)
    }

    /// Number of awake bodies.
    pub fn awake_count(&self) -> usize {
        let bodies = self.world.rigid_bodies();
        bodies.filter(|(_, body)| !body.is_fixed() && !body.is_sleeping()).count()
    }

    /// Number of joints.
    pub fn joint_count(&self) -> usize {
        self.world.impulse_joints().count()
    }

    /// Number of pairs Rapier keeps a contact for, touching or not.
    pub fn contact_count(&self) -> usize {
        self.world.contact_pairs().count()
    }

    /// Number of shape pairs that touch, and of their contact points.
    pub fn touching(&self) -> (usize, usize) {
        let touching = self.world.contact_pairs().filter(|pair| pair.has_any_active_contact());
        touching.fold((0, 0), |(pairs, points), pair| {
            let manifolds = match &pair.contacts {
                PairContacts::Rigid(rigid) => rigid.solver_manifolds(),
                PairContacts::Soft { .. } => &[],
            };
            let own: usize = manifolds.iter().map(|m| m.data.solver_contacts.len()).sum();
            (pairs + 1, points + own)
        })
    }
}

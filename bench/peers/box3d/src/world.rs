//! A thin owner of one Box3D world: builds bodies, steps, and reads back what the report needs.

use crate::shared::human::{Hold, REST_SPRING};
use crate::shared::parts::{
    BodyOptions, Capacity, DT_S, Frame, JOINT_SOFTNESS, Kind, Limb, Meets, SUBSTEPS, Shape, ShapeOptions, V,
};
use boxddd_sys::ffi;
use std::collections::BTreeSet;
use std::ffi::{CStr, c_char, c_int};
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};

static ASSERTS_SEEN: AtomicBool = AtomicBool::new(false);

unsafe extern "C" fn note_assert(_condition: *const c_char, _file: *const c_char, _line: c_int) -> c_int {
    ASSERTS_SEEN.store(true, Ordering::Relaxed);
    0
}

unsafe extern "C" fn log(message: *const c_char) {
    // SAFETY: Box3D passes a string that ends in zero and lives through the call.
    eprintln!("Box3D: {}", unsafe { CStr::from_ptr(message) }.to_string_lossy());
}

/// Sends Box3D's messages to standard error, away from the JSON lines.
pub fn log_to_stderr() {
    // SAFETY: the function lives as long as the program.
    unsafe { ffi::b3SetLogFcn(Some(log)) }
}

/// Whether the linked Box3D was compiled with its assertions: such a build is slower than what its users ship.
pub fn box3d_has_asserts() -> bool {
    // SAFETY: a handler that only sets a flag. The second call passes no handler, which trips Box3D's own
    // assertion "handler is not null" where assertions are compiled in; the third puts the handler back, so
    // that a later assertion never calls through null.
    unsafe {
        ffi::b3SetAssertFcn(Some(note_assert));
        ffi::b3SetAssertFcn(None);
        ffi::b3SetAssertFcn(Some(note_assert));
    }
    ASSERTS_SEEN.load(Ordering::Relaxed)
}

/// A body of the world.
pub type Body = ffi::b3BodyId;

fn vec3([x, y, z]: V) -> ffi::b3Vec3 {
    ffi::b3Vec3 { x, y, z }
}

fn quat(q: [f32; 4]) -> ffi::b3Quat {
    let length = q.iter().map(|c| c * c).sum::<f32>().sqrt();
    let [x, y, z, s] = q.map(|c| c / length);
    ffi::b3Quat { v: ffi::b3Vec3 { x, y, z }, s }
}

fn frame((p, q): Frame) -> ffi::b3Transform {
    ffi::b3Transform { p: vec3(p), q: quat(q) }
}

fn place((p, q): Frame) -> ffi::b3WorldTransform {
    ffi::b3WorldTransform { p: vec3(p), q: quat(q) }
}

/// A convex hull built by Box3D from points.
pub struct Hull(*mut ffi::b3HullData);

impl Hull {
    /// The hull of `points` (metres, body frame); says so where Box3D refuses them.
    pub fn new(points: &[V]) -> Result<Hull, String> {
        let points: Vec<_> = points.iter().copied().map(vec3).collect();
        let count = c_int::try_from(points.len()).map_err(|e| e.to_string())?;
        // SAFETY: the pointer and the count describe one live slice, which Box3D only reads.
        let hull = unsafe { ffi::b3CreateHull(points.as_ptr(), count, count) };
        if hull.is_null() {
            return Err(format!("Box3D built no hull from {count} points"));
        }
        Ok(Hull(hull))
    }
}

impl Drop for Hull {
    fn drop(&mut self) {
        // SAFETY: created by b3CreateHull and destroyed once; shapes hold their own copy.
        unsafe { ffi::b3DestroyHull(self.0) }
    }
}

/// A mesh of counter-clockwise triangles, shared between bodies.
pub struct Mesh(Rc<MeshData>);

struct MeshData(*mut ffi::b3MeshData);

impl Mesh {
    /// The mesh of `triangles` over `points` (metres, body frame), with its flat and concave edges marked.
    pub fn new(points: &[V], triangles: &[[u32; 3]]) -> Result<Mesh, String> {
        let count = |n: usize| c_int::try_from(n).map_err(|e| e.to_string());
        let mut points: Vec<_> = points.iter().copied().map(vec3).collect();
        let mut indices = Vec::with_capacity(3 * triangles.len());
        for &i in triangles.as_flattened() {
            indices.push(count(i as usize)?);
        }
        let def = ffi::b3MeshDef {
            vertices: points.as_mut_ptr(),
            indices: indices.as_mut_ptr(),
            materialIndices: std::ptr::null_mut(),
            weldTolerance: 0.0,
            vertexCount: count(points.len())?,
            triangleCount: count(triangles.len())?,
            weldVertices: false,
            useMedianSplit: false,
            identifyEdges: true,
        };
        // SAFETY: the pointers and counts describe live vectors, which Box3D copies; no list of degenerate
        // triangles is asked for.
        let mesh = unsafe { ffi::b3CreateMesh(&def, std::ptr::null_mut(), 0) };
        if mesh.is_null() {
            return Err(format!("Box3D built no mesh from {} triangles", triangles.len()));
        }
        Ok(Mesh(Rc::new(MeshData(mesh))))
    }
}

impl Drop for MeshData {
    fn drop(&mut self) {
        // SAFETY: created by b3CreateMesh and destroyed once; a world whose shapes use it holds on to it.
        unsafe { ffi::b3DestroyMesh(self.0) }
    }
}

/// One Box3D world with the bodies the scene created, in creation order.
pub struct World {
    id: ffi::b3WorldId,
    /// Bodies made so far that move, those removed again among them.
    dynamic: Vec<Body>,
    /// Bodies of all kinds now.
    count: usize,
    /// Dropped after the world.
    meshes: Vec<Rc<MeshData>>,
}

impl World {
    /// A world with Box3D's defaults, gravity along y in m/s², `threads` workers and room for `capacity`.
    pub fn new(threads: u32, gravity_y: f32, capacity: Capacity) -> Result<World, String> {
        let count = |n: u32| i32::try_from(n).map_err(|e| e.to_string());
        let (fixed, moving) = (count(capacity.fixed)?, count(capacity.moving)?);
        let capacity = ffi::b3Capacity {
            staticShapeCount: fixed,
            dynamicShapeCount: moving,
            staticBodyCount: fixed,
            dynamicBodyCount: moving,
            contactCount: count(capacity.contacts)?,
        };
        // SAFETY: plain constructor calls; the definition comes from Box3D itself and outlives the call.
        let id = unsafe {
            let mut def = ffi::b3DefaultWorldDef();
            def.gravity = vec3([0.0, gravity_y, 0.0]);
            def.workerCount = threads;
            def.capacity = capacity;
            ffi::b3CreateWorld(&def)
        };
        Ok(World { id, dynamic: Vec::new(), count: 0, meshes: Vec::new() })
    }

    /// Keeps every island awake.
    pub fn disable_sleep(&mut self) {
        // SAFETY: the world lives as long as `self`.
        unsafe { ffi::b3World_EnableSleeping(self.id, false) }
    }

    /// Creates a body without shapes.
    pub fn body(&mut self, options: &BodyOptions) -> Body {
        // SAFETY: the world is alive, and the definition comes from Box3D itself and holds no pointers of ours.
        let id = unsafe {
            let mut def = ffi::b3DefaultBodyDef();
            def.type_ = match options.kind {
                Kind::Fixed => ffi::b3BodyType_b3_staticBody,
                Kind::Kinematic => ffi::b3BodyType_b3_kinematicBody,
                Kind::Dynamic => ffi::b3BodyType_b3_dynamicBody,
            };
            let place = place(options.frame);
            (def.position, def.rotation) = (place.p, place.q);
            def.linearVelocity = vec3(options.velocity);
            def.angularVelocity = vec3(options.spin);
            def.enableSleep = options.can_sleep;
            def.sleepThreshold = options.sleep_speed;
            ffi::b3CreateBody(self.id, &def)
        };
        self.count += 1;
        if options.kind == Kind::Dynamic {
            self.dynamic.push(id);
        }
        id
    }

    /// Destroys a body with its shapes and joints.
    pub fn remove(&mut self, body: Body) {
        // SAFETY: the body belongs to this world and is removed once.
        unsafe { ffi::b3DestroyBody(body) }
        self.count -= 1;
    }

    /// Attaches a shape to a body of this world.
    pub fn shape(&mut self, body: Body, shape: &Shape, options: ShapeOptions) {
        // SAFETY: the body belongs to this world; Box3D copies the geometry it is given during the call.
        unsafe {
            let mut def = ffi::b3DefaultShapeDef();
            def.density = options.density;
            def.baseMaterial.friction = options.friction;
            def.baseMaterial.restitution = options.restitution;
            def.baseMaterial.rollingResistance = options.rolling;
            def.invokeContactCreation = options.buffer_move;
            match options.meets {
                Meets::All => {}
                Meets::NotGhosts => {
                    def.filter.categoryBits = 2;
                    def.filter.maskBits = !2;
                }
                Meets::NotGroup(group) => def.filter.groupIndex = -1 - group as c_int,
            }
            match shape {
                Shape::Box { half: [x, y, z], centre } => {
                    let hull = ffi::b3MakeOffsetBoxHull(*x, *y, *z, vec3(*centre));
                    ffi::b3CreateHullShape(body, &def, &raw const hull.base);
                }
                Shape::Sphere { radius } => {
                    let sphere = ffi::b3Sphere { center: vec3([0.0; 3]), radius: *radius };
                    ffi::b3CreateSphereShape(body, &def, &sphere);
                }
                Shape::Capsule { a, b, radius } => {
                    let capsule = ffi::b3Capsule { center1: vec3(*a), center2: vec3(*b), radius: *radius };
                    ffi::b3CreateCapsuleShape(body, &def, &capsule);
                }
                Shape::Hull(hull) => {
                    ffi::b3CreateHullShape(body, &def, hull.0);
                }
            }
        }
    }

    /// Attaches a mesh to a fixed body.
    pub fn mesh(&mut self, body: Body, mesh: &Mesh, options: ShapeOptions) {
        self.meshes.push(Rc::clone(&mesh.0));
        // SAFETY: the body belongs to this world, which holds on to the mesh.
        unsafe {
            let mut def = ffi::b3DefaultShapeDef();
            def.baseMaterial.friction = options.friction;
            def.baseMaterial.restitution = options.restitution;
            def.baseMaterial.rollingResistance = options.rolling;
            ffi::b3CreateMeshShape(body, &def, mesh.0.0, vec3([1.0; 3]));
        }
    }

    /// Where the centre of mass is, in the body's frame.
    pub fn local_center(&mut self, body: Body) -> V {
        // SAFETY: the body belongs to this world.
        let c = unsafe { ffi::b3Body_GetLocalCenter(body) };
        [c.x, c.y, c.z]
    }

    /// Sets the velocity of the centre of mass, m/s, and the spin, rad/s.
    pub fn set_velocity(&mut self, body: Body, v: V, w: V) {
        // SAFETY: as above.
        unsafe {
            ffi::b3Body_SetLinearVelocity(body, vec3(v));
            ffi::b3Body_SetAngularVelocity(body, vec3(w));
        }
    }

    fn joint(base: &mut ffi::b3JointDef, a: (Body, Frame), b: (Body, Frame)) {
        (base.bodyIdA, base.localFrameA) = (a.0, frame(a.1));
        (base.bodyIdB, base.localFrameB) = (b.0, frame(b.1));
        (base.constraintHertz, base.constraintDampingRatio) = JOINT_SOFTNESS;
    }

    /// Holds a point of A to a point of B, each in its body's frame; turning is free.
    pub fn ball_joint(&mut self, a: (Body, V), b: (Body, V)) {
        let unturned = [0.0, 0.0, 0.0, 1.0];
        // SAFETY: both bodies belong to this world; the definition started from Box3D's own.
        unsafe {
            let mut def = ffi::b3DefaultSphericalJointDef();
            Self::joint(&mut def.base, (a.0, (a.1, unturned)), (b.0, (b.1, unturned)));
            ffi::b3CreateSphericalJoint(self.id, &def);
        }
    }

    /// Joins two bones with limits, a spring to their rest and a motor that stands for friction.
    pub fn limb(&mut self, limb: &Limb) {
        let (a, b) = ((limb.a, limb.frame_a), (limb.b, limb.frame_b));
        // SAFETY: as above.
        unsafe {
            match limb.hold {
                Hold::Root => {}
                Hold::Ball(cone, lo, hi) => {
                    let mut def = ffi::b3DefaultSphericalJointDef();
                    Self::joint(&mut def.base, a, b);
                    (def.enableConeLimit, def.coneAngle) = (true, cone.to_radians());
                    def.enableTwistLimit = true;
                    (def.lowerTwistAngle, def.upperTwistAngle) = (lo.to_radians(), hi.to_radians());
                    def.enableSpring = true;
                    (def.hertz, def.dampingRatio) = REST_SPRING;
                    (def.enableMotor, def.maxMotorTorque) = (true, limb.friction);
                    ffi::b3CreateSphericalJoint(self.id, &def);
                }
                Hold::Hinge(lo, hi) => {
                    let mut def = ffi::b3DefaultRevoluteJointDef();
                    Self::joint(&mut def.base, a, b);
                    def.enableLimit = true;
                    (def.lowerAngle, def.upperAngle) = (lo.to_radians(), hi.to_radians());
                    def.enableSpring = true;
                    (def.hertz, def.dampingRatio) = REST_SPRING;
                    (def.enableMotor, def.maxMotorTorque) = (true, limb.friction);
                    ffi::b3CreateRevoluteJoint(self.id, &def);
                }
            }
        }
    }

    /// Keeps two bodies from touching each other.
    pub fn pass_through(&mut self, a: Body, b: Body) {
        // SAFETY: as above.
        unsafe {
            let mut def = ffi::b3DefaultFilterJointDef();
            (def.base.bodyIdA, def.base.bodyIdB) = (a, b);
            ffi::b3CreateFilterJoint(self.id, &def);
        }
    }

    /// Gives a kinematic body the velocity that reaches the position, unturned, in one step.
    pub fn move_to(&mut self, body: Body, x: f32, y: f32, z: f32) {
        let target = place(([x, y, z], [0.0, 0.0, 0.0, 1.0]));
        // SAFETY: the body belongs to this world.
        unsafe { ffi::b3Body_SetTargetTransform(body, target, DT_S, false) }
    }

    /// One step of `DT_S` with `SUBSTEPS` substeps.
    pub fn step(&mut self) {
        // SAFETY: the world is alive, and no callback of ours runs inside.
        unsafe { ffi::b3World_Step(self.id, DT_S, SUBSTEPS as c_int) }
    }

    /// Number of all bodies.
    pub fn body_count(&self) -> usize {
        self.count
    }

    fn moving(&self) -> impl Iterator<Item = Body> {
        // SAFETY: asks whether the id still names a body.
        self.dynamic.iter().copied().filter(|&body| unsafe { ffi::b3Body_IsValid(body) })
    }

    /// Heights of the dynamic bodies in creation order, in metres.
    pub fn dynamic_heights(&self) -> Vec<f32> {
        // SAFETY: each body is one of this world.
        self.moving().map(|body| unsafe { ffi::b3Body_GetPosition(body) }.y).collect()
    }

    /// Greatest speed of a dynamic body, in m/s.
    pub fn speed_max(&self) -> f32 {
        let speed = |body: Body| {
            // SAFETY: as above.
            let v = unsafe { ffi::b3Body_GetLinearVelocity(body) };
            (v.x * v.x + v.y * v.y + v.z * v.z).sqrt()
        };
        self.moving().map(speed).fold(0.0, f32::max)
    }

    /// Number of awake bodies.
    pub fn awake_count(&self) -> i32 {
        // SAFETY: the world is alive.
        unsafe { ffi::b3World_GetAwakeBodyCount(self.id) }
    }

    /// Number of joints.
    pub fn joint_count(&self) -> i32 {
        // SAFETY: the world is alive.
        unsafe { ffi::b3World_GetCounters(self.id) }.jointCount
    }

    /// Number of pairs Box3D keeps a contact for, touching or not.
    pub fn contact_count(&self) -> i32 {
        // SAFETY: the world is alive.
        unsafe { ffi::b3World_GetCounters(self.id) }.contactCount
    }

    /// Number of shape pairs that touch, and of their contact points.
    pub fn touching(&self) -> (usize, usize) {
        let mut seen = BTreeSet::new();
        let mut points = 0;
        for body in self.moving() {
            // SAFETY: the buffer holds `capacity` elements and Box3D says how many it filled; the manifolds it
            // points to stay valid until the next step.
            unsafe {
                let capacity = ffi::b3Body_GetContactCapacity(body);
                let mut data = Vec::<ffi::b3ContactData>::with_capacity(capacity.max(0) as usize);
                let filled = ffi::b3Body_GetContactData(body, data.as_mut_ptr(), capacity);
                data.set_len(filled.max(0) as usize);
                for contact in &data {
                    if seen.insert(contact.contactId.index1) && !contact.manifolds.is_null() {
                        let count = contact.manifoldCount.max(0) as usize;
                        let manifolds = std::slice::from_raw_parts(contact.manifolds, count);
                        points += manifolds.iter().map(|m| m.pointCount as usize).sum::<usize>();
                    }
                }
            }
        }
        (seen.len(), points)
    }
}

impl Drop for World {
    fn drop(&mut self) {
        // SAFETY: created in `new`, destroyed once.
        unsafe { ffi::b3DestroyWorld(self.id) }
    }
}

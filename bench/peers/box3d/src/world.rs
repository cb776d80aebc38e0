//! A thin owner of one Box3D world: builds bodies, steps, and reads back what the report needs.

use boxddd_sys::ffi;
use std::collections::BTreeSet;
use std::ffi::{c_char, c_int};
use std::sync::atomic::{AtomicBool, Ordering};

/// Fixed step of every scene, in seconds.
pub const DT_S: f32 = 1.0 / 60.0;
/// Substeps per step of every scene.
pub const SUBSTEPS: i32 = 4;

static ASSERTS_SEEN: AtomicBool = AtomicBool::new(false);

unsafe extern "C" fn note_assert(_condition: *const c_char, _file: *const c_char, _line: c_int) -> c_int {
    ASSERTS_SEEN.store(true, Ordering::Relaxed);
    0
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

/// A vector in Box3D's layout.
pub fn vec3(x: f32, y: f32, z: f32) -> ffi::b3Vec3 {
    ffi::b3Vec3 { x, y, z }
}

/// The identity rotation.
pub fn identity() -> ffi::b3Quat {
    ffi::b3Quat { v: vec3(0.0, 0.0, 0.0), s: 1.0 }
}

/// A convex hull built by Box3D from points.
pub struct Hull(*mut ffi::b3HullData);

impl Hull {
    /// The hull of `points` (metres, body frame); says so where Box3D refuses them.
    pub fn new(points: &[ffi::b3Vec3]) -> Result<Hull, String> {
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

/// What a shape is made of here.
pub enum Shape<'a> {
    /// Half extents in metres, and the centre in the body's frame.
    Box { half: [f32; 3], centre: [f32; 3] },
    /// Radius in metres, centred on the body.
    Sphere { radius: f32 },
    /// Half the length between the centres of the caps, along y, and their radius, in metres.
    Capsule { half_height: f32, radius: f32 },
    /// A hull shared between bodies.
    Hull(&'a Hull),
}

impl Shape<'_> {
    /// A box centred on its body; half extents in metres.
    pub fn block(x: f32, y: f32, z: f32) -> Self {
        Shape::Box { half: [x, y, z], centre: [0.0; 3] }
    }
}

/// Material, density and creation options of a shape.
#[derive(Clone, Copy)]
pub struct ShapeOptions {
    /// kg/m³
    pub density: f32,
    /// Coefficient of friction.
    pub friction: f32,
    /// Coefficient of restitution.
    pub restitution: f32,
    /// Rolling resistance, of balls and capsules.
    pub rolling: f32,
    /// A static shape looks for contacts at creation.
    pub buffer_move: bool,
    /// Touches nothing of its own kind.
    pub ghost: bool,
}

impl Default for ShapeOptions {
    fn default() -> Self {
        ShapeOptions {
            density: 1000.0,
            friction: 0.6,
            restitution: 0.0,
            rolling: 0.0,
            buffer_move: false,
            ghost: false,
        }
    }
}

/// One Box3D world with the bodies the scene created, in creation order.
pub struct World {
    id: ffi::b3WorldId,
    bodies: Vec<ffi::b3BodyId>,
    dynamic: Vec<ffi::b3BodyId>,
    meshes: Vec<*mut ffi::b3MeshData>,
}

impl World {
    /// A world with Box3D's defaults, gravity along y in m/s², `threads` workers and room for `capacity`.
    pub fn new(threads: u32, gravity_y: f32, capacity: ffi::b3Capacity) -> World {
        // SAFETY: plain constructor calls; the definition comes from Box3D itself and outlives the call.
        let id = unsafe {
            let mut def = ffi::b3DefaultWorldDef();
            def.gravity = vec3(0.0, gravity_y, 0.0);
            def.workerCount = threads;
            def.capacity = capacity;
            ffi::b3CreateWorld(&def)
        };
        World { id, bodies: Vec::new(), dynamic: Vec::new(), meshes: Vec::new() }
    }

    /// Keeps every island awake.
    pub fn disable_sleep(&mut self) {
        // SAFETY: the world lives as long as `self`.
        unsafe { ffi::b3World_EnableSleeping(self.id, false) }
    }

    /// A body definition at a position with Box3D's defaults.
    pub fn body_def(kind: ffi::b3BodyType, x: f32, y: f32, z: f32) -> ffi::b3BodyDef {
        // SAFETY: returns a plain value.
        let mut def = unsafe { ffi::b3DefaultBodyDef() };
        def.type_ = kind;
        def.position = vec3(x, y, z);
        def
    }

    /// Creates a body without shapes.
    pub fn body(&mut self, def: &ffi::b3BodyDef) -> ffi::b3BodyId {
        // SAFETY: the definition started from b3DefaultBodyDef and holds no pointers of ours.
        let id = unsafe { ffi::b3CreateBody(self.id, def) };
        self.bodies.push(id);
        if def.type_ == ffi::b3BodyType_b3_dynamicBody {
            self.dynamic.push(id);
        }
        id
    }

    /// Attaches a shape to a body of this world.
    pub fn shape(&mut self, body: ffi::b3BodyId, shape: &Shape, options: ShapeOptions) {
        // SAFETY: the body belongs to this world; Box3D copies the geometry it is given during the call.
        unsafe {
            let mut def = ffi::b3DefaultShapeDef();
            def.density = options.density;
            def.baseMaterial.friction = options.friction;
            def.baseMaterial.restitution = options.restitution;
            def.baseMaterial.rollingResistance = options.rolling;
            def.invokeContactCreation = options.buffer_move;
            if options.ghost {
                def.filter.categoryBits = 2;
                def.filter.maskBits = !2;
            }
            match shape {
                Shape::Box { half: [x, y, z], centre: [cx, cy, cz] } => {
                    let hull = ffi::b3MakeOffsetBoxHull(*x, *y, *z, vec3(*cx, *cy, *cz));
                    ffi::b3CreateHullShape(body, &def, &raw const hull.base);
                }
                Shape::Sphere { radius } => {
                    let sphere = ffi::b3Sphere { center: vec3(0.0, 0.0, 0.0), radius: *radius };
                    ffi::b3CreateSphereShape(body, &def, &sphere);
                }
                Shape::Capsule { half_height, radius } => {
                    let capsule = ffi::b3Capsule {
                        center1: vec3(0.0, -half_height, 0.0),
                        center2: vec3(0.0, *half_height, 0.0),
                        radius: *radius,
                    };
                    ffi::b3CreateCapsuleShape(body, &def, &capsule);
                }
                Shape::Hull(hull) => {
                    ffi::b3CreateHullShape(body, &def, hull.0);
                }
            }
        }
    }

    /// Attaches a mesh of counter-clockwise triangles to a fixed body.
    pub fn mesh(
        &mut self,
        body: ffi::b3BodyId,
        points: &mut [ffi::b3Vec3],
        triangles: &[[usize; 3]],
        options: ShapeOptions,
    ) -> Result<(), String> {
        let count = |n: usize| c_int::try_from(n).map_err(|e| e.to_string());
        let mut indices = Vec::with_capacity(3 * triangles.len());
        for &i in triangles.as_flattened() {
            indices.push(count(i)?);
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
        // SAFETY: the pointers and counts describe live vectors, which Box3D copies; no list of degenerate triangles is asked for.
        // The mesh is destroyed after the world whose shapes use it.
        unsafe {
            let mesh = ffi::b3CreateMesh(&def, std::ptr::null_mut(), 0);
            if mesh.is_null() {
                return Err(format!("Box3D built no mesh from {} triangles", triangles.len()));
            }
            self.meshes.push(mesh);
            let mut def = ffi::b3DefaultShapeDef();
            def.baseMaterial.friction = options.friction;
            def.baseMaterial.restitution = options.restitution;
            ffi::b3CreateMeshShape(body, &def, mesh, vec3(1.0, 1.0, 1.0));
        }
        Ok(())
    }

    /// Where the centre of mass is, in the body's frame.
    pub fn local_center(&self, body: ffi::b3BodyId) -> ffi::b3Vec3 {
        // SAFETY: the body belongs to this world.
        unsafe { ffi::b3Body_GetLocalCenter(body) }
    }

    /// Sets the velocity of the centre of mass, m/s, and the spin, rad/s.
    pub fn set_velocity(&mut self, body: ffi::b3BodyId, v: ffi::b3Vec3, w: ffi::b3Vec3) {
        // SAFETY: as above.
        unsafe {
            ffi::b3Body_SetLinearVelocity(body, v);
            ffi::b3Body_SetAngularVelocity(body, w);
        }
    }

    /// Holds a point of A to a point of B, each in its body's frame; turning is free.
    pub fn ball_joint(&mut self, a: (ffi::b3BodyId, ffi::b3Vec3), b: (ffi::b3BodyId, ffi::b3Vec3)) {
        // SAFETY: both bodies belong to this world; the definition started from Box3D's own.
        unsafe {
            let mut def = ffi::b3DefaultSphericalJointDef();
            (def.base.bodyIdA, def.base.localFrameA.p) = a;
            (def.base.bodyIdB, def.base.localFrameB.p) = b;
            ffi::b3CreateSphericalJoint(self.id, &def);
        }
    }

    /// Gives a kinematic body the velocity that reaches the position, unturned, in one step.
    pub fn move_to(&mut self, body: ffi::b3BodyId, x: f32, y: f32, z: f32) {
        let target = ffi::b3WorldTransform { p: vec3(x, y, z), q: identity() };
        // SAFETY: the body belongs to this world.
        unsafe { ffi::b3Body_SetTargetTransform(body, target, DT_S, false) }
    }

    /// One step of `DT_S` with `SUBSTEPS` substeps.
    pub fn step(&mut self) {
        // SAFETY: the world is alive, and no callback of ours runs inside.
        unsafe { ffi::b3World_Step(self.id, DT_S, SUBSTEPS) }
    }

    /// Number of all bodies.
    pub fn body_count(&self) -> usize {
        self.bodies.len()
    }

    /// Heights of the dynamic bodies in creation order, in metres.
    pub fn dynamic_heights(&self) -> Vec<f32> {
        // SAFETY: each id was created in this world and is never destroyed before it.
        self.dynamic.iter().map(|&body| unsafe { ffi::b3Body_GetPosition(body) }.y).collect()
    }

    /// Greatest speed of a dynamic body, in m/s.
    pub fn speed_max(&self) -> f32 {
        let speed = |&body: &ffi::b3BodyId| {
            // SAFETY: as above.
            let v = unsafe { ffi::b3Body_GetLinearVelocity(body) };
            (v.x * v.x + v.y * v.y + v.z * v.z).sqrt()
        };
        self.dynamic.iter().map(speed).fold(0.0, f32::max)
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
        for &body in &self.dynamic {
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
        unsafe {
            ffi::b3DestroyWorld(self.id);
            self.meshes.iter().for_each(|&mesh| ffi::b3DestroyMesh(mesh));
        }
    }
}

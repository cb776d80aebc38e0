//! No ghost bumps across neighbouring bodies.
//!
//! A box that slides from one tile onto the next touches the next tile's edge, or its hidden side, a moment before its top.
//! A manifold against a fixed body whose points all lie in the plane of another, face, manifold of the same moving body says
//! nothing that this face does not say: it takes the face's normal, or is dropped when it is a single point. Not where its shape
//! stands out over that plane, though: a cone that slides along one wall of a corner touches the other wall in points of
//! the first one's plane only, however deep, and would go through. Every test reads the manifolds as the narrow phase left them, so the
//! order of the contacts does not matter.

use super::{Step, narrowphase};
use crate::room::contacts::state::ContactPlace;
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::NONE;
use crate::world::World;
use jounce_geometry::{Aabb, FACE_A, FACE_B};
use jounce_math::{DVec3, Vec3};

/// Cosine of the angle (18°) up to which a lean counts as the plane's own.
const LEAN_COSINE: f32 = 0.95;

/// Bodies per unit.
const BODIES: usize = 32;

/// What takes another normal, or none: it is dropped.
pub(crate) type Seam = (Patch, Option<Vec3>);

/// A manifold against a fixed body, seen from the moving body's centre of mass, world axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    row: u32,
    index: usize,
    /// Out of the fixed body.
    normal: Vec3,
    /// On the fixed body's surface.
    points: [Vec3; 4],
    count: usize,
    face: bool,
    slop: f32,
    fixed_is_a: bool,
}

pub(crate) fn run(world: &mut World, _: &Step) {
    // Where no manifold is new, all have the normals that they would get.
    let mut bodies = core::mem::take(&mut world.scratch.renewed);
    bodies.retain(|&b| world.bodies[b].kind == BodyKind::Dynamic && world.row_of[b as usize] != NONE);
    bodies.sort_unstable();
    bodies.dedup();
    let mut seams = core::mem::take(&mut world.scratch.seams);
    seams.begin(bodies.len().div_ceil(BODIES), 0);
    let (shared, lists): (&World, _) = (world, &seams);
    shared.tasks.for_each_piece(&bodies[..], BODIES, |first, bodies| {
        shared.scratch.patches.lend(|patches| {
            bodies.iter().for_each(|&b| body(shared, b, patches, &mut lists.of(first / BODIES)));
        });
    });
    seams.for_each(|(m, normal)| {
        let row = m.row as usize;
        if core::mem::take(&mut world.heads[row].kept) {
            let mut contacts = core::mem::take(&mut world.contacts);
            narrowphase::keep(world, &mut contacts[row]);
            world.contacts = contacts;
        }
        match normal {
            Some(normal) => adopt(world, m, *normal),
            None => drop(world, m),
        }
    });
    (world.scratch.renewed, world.scratch.seams) = (bodies, seams);
}

fn body(world: &World, slot: u32, patches: &mut Vec<Patch>, changes: &mut Vec<Seam>) {
    if gather(world, slot, patches) < 2 {
        return;
    }
    let center = world.frames[slot as usize].center;
    for m in patches.iter() {
        let face = patches.iter().find(|f| {
            (f.row, f.index) != (m.row, m.index)
                && f.face
                && lies_on(m, f)
                && (!m.face || !lies_on(f, m))
                && (f.normal.dot(m.normal) > LEAN_COSINE || !stands_out(world, center, m, f))
        });
        // What has the normal already keeps it: another face of the same points would give it back and forth.
        if let Some(f) = face.filter(|f| f.normal != m.normal) {
            let dropped = m.count == 1 && world.contacts[m.row as usize].rest.is_empty();
            changes.push((*m, (!dropped).then_some(f.normal)));
        }
    }
}

/// Do all points of `m` lie in the plane of `f`?
fn lies_on(m: &Patch, f: &Patch) -> bool {
    m.points[..m.count].iter().all(|p| f.normal.dot(*p - f.points[0]).abs() <= m.slop)
}

/// Does the shape of `m` rise over the plane of `f` where `m` touches it? `center` is where the patches' points are seen from.
fn stands_out(world: &World, center: DVec3, m: &Patch, f: &Patch) -> bool {
    let c = &world.contacts[m.row as usize];
    let shape = &world.shapes[if m.fixed_is_a { c.shape_a } else { c.shape_b }];
    let at = world.frames[shape.body as usize].shape_pose(&shape.pose);
    let local = |p: Vec3| at.q.inverse_rotate(p - (at.p - center).as_vec3());
    let normal = at.q.inverse_rotate(f.normal);
    let near = Aabb::from_points(m.points[..m.count].iter().map(|p| local(*p))).expanded(m.slop);
    shape.shape.rises_over(normal, normal.dot(local(f.points[0])) + m.slop, &near)
}

/// The patches of a body; gives of how many contacts they are.
fn gather(world: &World, slot: u32, patches: &mut Vec<Patch>) -> usize {
    patches.clear();
    let mut contacts = 0;
    let center = world.frames[slot as usize].center;
    for &id in &world.bodies[slot].contacts {
        let ContactPlace::Awake(row) = world.places[id as usize] else { continue };
        let c = &world.contacts[row as usize];
        if !c.fixed || !c.touching {
            continue;
        }
        contacts += 1;
        let fixed_is_a = c.body_b == slot;
        let fa = &world.frames[c.body_a as usize];
        let fb = &world.frames[c.body_b as usize];
        for (index, m) in c.manifolds().enumerate() {
            let normal = m.normal;
            let mut points = [Vec3::ZERO; 4];
            for (q, p) in points.iter_mut().zip(&m.anchors) {
                let (f, local) = if fixed_is_a { (fa, p.on_a) } else { (fb, p.on_b) };
                *q = (f.center - center).as_vec3() + f.rotation.rotate(local);
            }
            let bit = if fixed_is_a { FACE_A } else { FACE_B };
            patches.push(Patch {
                row,
                index,
                normal: if fixed_is_a { normal } else { -normal },
                points,
                count: usize::from(m.count),
                face: m.faces & bit != 0,
                slop: c.slop,
                fixed_is_a,
            });
        }
    }
    contacts
}

/// A single point in the plane of a face that carries the body already would carry it twice: a rolling ball would rise and
/// sink by half its contact's sag at every seam.
fn drop(world: &mut World, m: &Patch) {
    let c = &mut world.contacts[m.row as usize];
    let Some(manifold) = c.manifolds_mut().nth(m.index) else { return };
    manifold.count = 0;
    c.tested = false;
    world.heads[m.row as usize].until = f64::NEG_INFINITY;
}

/// Gives a manifold another normal; its points stay, their gaps are measured along the new one.
fn adopt(world: &mut World, m: &Patch, normal: Vec3) {
    let c = &mut world.contacts[m.row as usize];
    let (fa, fb) = (&world.frames[c.body_a as usize], &world.frames[c.body_b as usize]);
    let d = (fb.center - fa.center).as_vec3();
    let Some(manifold) = c.manifolds_mut().nth(m.index) else { return };
    manifold.normal = if m.fixed_is_a { normal } else { -normal };
    for (p, at) in manifold.points.iter_mut().zip(&manifold.anchors).take(m.count) {
        p.separation = (d + fb.rotation.rotate(at.on_b) - fa.rotation.rotate(at.on_a)).dot(manifold.normal);
    }
    // It is kept with this normal while the pair hardly moves.
}

#[cfg(test)]
mod tests {
    use crate::{BodyDesc, Command, ShapeDesc, World, WorldDesc};
    use jounce_geometry::{TriMesh, TriMeshOptions};
    use jounce_math::Vec3;
    use std::sync::Arc;

    /// A plank of several parts on a floor of many triangles is in touch by edges, which take the normals of faces beside them. That is no reason to
    /// test a pair again that does not move.
    #[test]
    fn adopted_normals_are_kept_while_nothing_moves() {
        const SIDE: u32 = 24;
        let corner = |i: u32| {
            let (x, z) = (0.25 * (i / (SIDE + 1)) as f32 - 3.0, 0.25 * (i % (SIDE + 1)) as f32 - 3.0);
            let wave = |x: f32| 0.05 * (x * x - x.abs());
            Vec3::new(x, wave(x) + wave(z), z)
        };
        let corners: Vec<Vec3> = (0..(SIDE + 1) * (SIDE + 1)).map(corner).collect();
        let quad = |k: u32| {
            let s = k / SIDE * (SIDE + 1) + k % SIDE;
            [[s, s + 1, s + SIDE + 2], [s, s + SIDE + 2, s + SIDE + 1]]
        };
        let triangles: Vec<[u32; 3]> = (0..SIDE * SIDE).flat_map(quad).collect();
        let mesh = TriMesh::new(&corners, &triangles, TriMeshOptions::default()).expect("a mesh");
        let mut w = World::new(WorldDesc::default()).expect("valid");
        w.add_body(BodyDesc::fixed().shape(ShapeDesc::mesh(Arc::new(mesh)))).expect("valid");
        let mut plank = BodyDesc::dynamic().at([0.1, 0.8, 0.2]);
        for k in 0..5 {
            let part = ShapeDesc::cuboid([0.2, 0.1, 0.2]);
            plank = plank.shape(part.at([0.4 * k as f32 - 0.8, 0.0, 0.0]));
        }
        let plank = w.add_body(plank).expect("valid");
        w.apply(Command::SetCanSleep(plank, false)).expect("valid");
        let (mut tests, mut touching, mut before) = (0, 0, Vec::new());
        for step in 0..300 {
            w.step().expect("valid");
            let now: Vec<_> =
                w.contacts.iter().filter(|c| c.touching).map(|c| (c.id, c.tested_pose)).collect();
            if step >= 240 {
                touching += now.len();
                tests += now.iter().filter(|c| !before.contains(*c)).count();
            }
            before = now;
        }
        // Some tremble at the edge of what counts as still; most do not.
        assert!(
            touching >= 60 && tests < touching / 10,
            "{tests} tests of {touching} pairs that touch, at rest"
        );
    }
}

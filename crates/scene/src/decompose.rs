//! A mesh cut into convex parts, by V-HACD (Mamou, Lengyel, Peters 2016) as parry3d implements it. Only the partition
//! is taken from there: the hulls are built by the engine's own builder, which refuses by name instead of panicking.

use crate::error::{Checked, Wrong};
use crate::limits;
use crate::mesh::MeshData;
use crate::spec::DecomposeSpec;
use jounce::geometry::{Compound, Hull, Shape};
use jounce::math::{Pose, Vec3};
use parry3d::math::Vector;
use parry3d::transformation::vhacd::{VHACD, VHACDParameters};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// Most triangles of a mesh to cut.
const TRIANGLES_MAX: usize = 1 << 17;

pub(crate) fn decompose(spec: &DecomposeSpec, mesh: &MeshData) -> Checked<Compound> {
    let concavity = spec.concavity.unwrap_or(0.01);
    if !(0.0..=1.0).contains(&concavity) {
        return Err(Wrong::new(format!("is {concavity}"), "0 to 1").key("concavity"));
    }
    let resolution = spec.resolution.unwrap_or(64);
    if !(8..=128).contains(&resolution) {
        return Err(Wrong::new(format!("is {resolution}"), "8 to 128").key("resolution"));
    }
    let parts_max = spec.parts_max.unwrap_or(64);
    if !(1..=256).contains(&parts_max) {
        return Err(Wrong::new(format!("is {parts_max}"), "1 to 256").key("parts_max"));
    }
    if mesh.triangles.len() > TRIANGLES_MAX {
        let message = format!("the mesh has {} triangles", mesh.triangles.len());
        return Err(Wrong::new(message, format!("at most {TRIANGLES_MAX}")).key("mesh"));
    }
    let params =
        VHACDParameters { concavity, resolution, max_convex_hulls: parts_max, ..VHACDParameters::default() };
    let (points, size) = normalised(mesh);
    let cells = cells_crossed(&points, &mesh.triangles, resolution);
    if cells > limits::CUT_CELLS_MAX {
        let message = format!("its triangles cross {cells:.0} cells at resolution {resolution}");
        return Err(
            Wrong::new(message, format!("at most {}; a lower resolution", limits::CUT_CELLS_MAX)).key("mesh")
        );
    }
    // The cutter asserts on meshes that it cannot voxelise; a scene must answer with an error.
    let cut = catch_unwind(AssertUnwindSafe(|| {
        VHACD::decompose(&params, &points, &mesh.triangles, true)
            .compute_primitive_intersections(&points, &mesh.triangles)
    }));
    let parts = cut.map_err(|_| {
        Wrong::new("the mesh cannot be cut into convex parts", "a closed mesh of moderate size").key("mesh")
    })?;
    let mut children = Vec::with_capacity(parts.len());
    for part in parts {
        let corners: Vec<Vec3> = part.iter().map(|p| size.0 + Vec3::new(p.x, p.y, p.z) * size.1).collect();
        // Parts that only graze the surface have no volume: they hold no matter.
        if let Ok(hull) = Hull::new(&corners) {
            children.push((Pose::IDENTITY, Shape::Hull(Arc::new(hull))));
        }
    }
    if children.is_empty() {
        return Err(Wrong::new("no part of the mesh has volume", "a closed mesh").key("mesh"));
    }
    Ok(Compound::new(children)?)
}

/// About how many cells the triangles cross, each counted for every triangle: what the cutter's memory goes with.
fn cells_crossed(points: &[Vector], triangles: &[[u32; 3]], resolution: u32) -> f64 {
    let per_metre = 0.5 * f64::from(resolution);
    let cells = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| points[v as usize]);
        let (ab, ac) = (b - a, c - a);
        let around = f64::from(ab.length() + ac.length() + (c - b).length());
        let area = 0.5 * f64::from(ab.cross(ac).length());
        1.0 + per_metre * around + per_metre * per_metre * area
    };
    triangles.iter().map(cells).sum()
}

/// Vertices in the cube ±1, with the middle and the scale that undo it.
fn normalised(mesh: &MeshData) -> (Vec<Vector>, (Vec3, f32)) {
    let used = || mesh.triangles.iter().flatten().map(|&v| mesh.vertices[v as usize]);
    let (mut lo, mut hi) = (Vec3::splat(f32::MAX), Vec3::splat(-f32::MAX));
    for v in used() {
        lo = lo.min(v);
        hi = hi.max(v);
    }
    let middle = (lo + hi) * 0.5;
    let half = (hi - lo).max_component() * 0.5;
    let scale = if half > 0.0 && half.is_finite() { half } else { 1.0 };
    let place = |v: &Vec3| {
        let p = (*v - middle) / scale;
        Vector::new(p.x, p.y, p.z)
    };
    (mesh.vertices.iter().map(place).collect(), (middle, scale))
}

//! Slabs around a convex shape. A triangle beyond one of them is apart from the shape; most that are near it are found to be so here,
//! without a look at their features.

use crate::convex::Sweep;
use crate::convex::core::Core;
use crate::Aabb;
use jounce_math::{Pose, Vec3, scalar::f32s};

/// Directions abreast.
const WIDE: usize = 4;
/// Most directions: of a hull with more faces only so many are asked.
const DIRECTIONS_MAX: usize = 16;
/// Room for rounding, in the largest coordinate at hand.
const SLACK: f32 = 2e-6;
/// Half of √3.
const SIDE: f32 = 0.866_025_4;

/// A shape's reach along its own face normals, in the surface's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sieve {
    /// x, y, z of four unit directions, and how far along them the shape reaches.
    blocks: [[[f32; WIDE]; 4]; DIRECTIONS_MAX / WIDE],
    used: usize,
}

impl Sieve {
    /// Around `core` and all within `reach` (its radius included) of it.
    pub fn new(core: &Core, pose: &Pose, reach: f32, surface: &Aabb) -> Self {
        let more = reach + slack(surface, core, pose.p.abs().max_component());
        Self::with(core, |d| {
            let n = pose.q.rotate(d);
            (n, d.dot(core.support(d)) + n.dot(pose.p) + more)
        })
    }

    /// Around all places of a moving core, where no point leaves the chord of its turn by more than `sagitta`.
    pub fn swept(core: &Core, sweep: &Sweep, reach: f32, surface: &Aabb) -> Self {
        let [q0, q1] = sweep.rotation;
        let [from, to] = sweep.center;
        let far = f32s::max(from.abs().max_component(), to.abs().max_component());
        let more = reach + slack(surface, core, far + sweep.local_center.length());
        Self::with(core, |d| {
            let n = q0.rotate(d);
            let e = q1.inverse_rotate(n);
            let turned = f32s::max(
                d.dot(core.support(d) - sweep.local_center),
                e.dot(core.support(e) - sweep.local_center),
            );
            (n, turned + f32s::max(n.dot(from), n.dot(to)) + more)
        })
    }

    fn with(core: &Core, slab: impl Fn(Vec3) -> (Vec3, f32)) -> Self {
        let mut s = Self { blocks: [[[0.0; WIDE]; 4]; DIRECTIONS_MAX / WIDE], used: 0 };
        let mut put = |i: usize, d: Vec3| {
            let (n, limit) = slab(d);
            let block = &mut s.blocks[i / WIDE];
            for (lanes, x) in block.iter_mut().zip([n.x, n.y, n.z, limit]) {
                // Lanes that stay empty repeat the last direction.
                lanes[i % WIDE..].fill(x);
            }
            s.used = i / WIDE + 1;
        };
        match core {
            Core::Hull(h) => {
                let count = h.faces.len().min(DIRECTIONS_MAX);
                (0..count).for_each(|i| put(i, h.faces[i * h.faces.len() / count].normal));
            }
            Core::Box(_) => {
                let axes = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
                axes.into_iter().enumerate().for_each(|(i, d)| put(i, d));
            }
            Core::Segment(_) | Core::Cylinder(..) | Core::Cone(..) => {
                let around = [(1.0, 0.0), (0.5, SIDE), (-0.5, SIDE), (-1.0, 0.0), (-0.5, -SIDE), (0.5, -SIDE)];
                let around = around.map(|(x, z)| Vec3::new(x, 0.0, z));
                let all = [Vec3::Y, -Vec3::Y].into_iter().chain(around);
                all.enumerate().for_each(|(i, d)| put(i, d));
            }
            Core::Point | Core::Triangle(_) => {}
        }
        s
    }

    /// May the triangle be within reach?
    #[inline]
    pub fn passes(&self, t: &[Vec3; 3]) -> bool {
        for [x, y, z, limit] in &self.blocks[..self.used] {
            let mut apart = 0_u32;
            for i in 0..WIDE {
                let h = |p: Vec3| x[i] * p.x + y[i] * p.y + z[i] * p.z;
                let low = f32s::min(f32s::min(h(t[0]), h(t[1])), h(t[2]));
                apart |= u32::from(low > limit[i]);
            }
            if apart != 0 {
                return false;
            }
        }
        true
    }

    /// The same where the shape may be as deep as `deep` under a triangle of normal `n`, and all of the triangle below the shape counts:
    /// under a face that leans over it that is more than what is within reach.
    #[inline]
    pub fn passes_below(&self, t: &[Vec3; 3], n: Vec3, deep: f32) -> bool {
        for [x, y, z, limit] in &self.blocks[..self.used] {
            let mut apart = 0_u32;
            for i in 0..WIDE {
                let h = |p: Vec3| x[i] * p.x + y[i] * p.y + z[i] * p.z;
                let low = f32s::min(f32s::min(h(t[0]), h(t[1])), h(t[2]));
                let lean = deep * f32s::max(h(n), 0.0);
                apart |= u32::from(low - lean > limit[i]);
            }
            if apart != 0 {
                return false;
            }
        }
        true
    }
}

fn slack(surface: &Aabb, core: &Core, far: f32) -> f32 {
    SLACK * (surface.min.abs().max(surface.max.abs()).max_component() + core.extent() + far)
}

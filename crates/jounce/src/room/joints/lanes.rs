//! Rotations, symmetric matrices and angles in lanes.

use crate::room::contacts::rows::{Lane, Wide3};
use jounce_lanes::{Lanes, six};

/// A rotation per lane.
#[derive(Clone, Copy)]
pub(crate) struct WideQuat<L> {
    pub v: Wide3<L>,
    pub w: L,
}

impl<L: Lanes> WideQuat<L> {
    #[inline(always)]
    pub fn load(q: &[Lane; 4], at: usize) -> Self {
        let v = Wide3::new(L::load(&q[0][at..]), L::load(&q[1][at..]), L::load(&q[2][at..]));
        Self { v, w: L::load(&q[3][at..]) }
    }
    #[inline(always)]
    pub fn store(self, q: &mut [Lane; 4], at: usize) {
        self.v.x.store(&mut q[0][at..]);
        self.v.y.store(&mut q[1][at..]);
        self.v.z.store(&mut q[2][at..]);
        self.w.store(&mut q[3][at..]);
    }
    #[inline(always)]
    pub fn conjugate(self) -> Self {
        Self { v: Wide3::new(-self.v.x, -self.v.y, -self.v.z), w: self.w }
    }
    #[inline(always)]
    pub fn times(self, o: Self) -> Self {
        let v = o.v.scale(self.w).add(self.v.scale(o.w)).add(self.v.cross(o.v));
        Self { v, w: self.w * o.w - self.v.dot(o.v) }
    }
    #[inline(always)]
    pub fn rotate(self, r: Wide3<L>) -> Wide3<L> {
        let t = self.v.cross(r).scale(L::splat(2.0));
        r.add(t.scale(self.w)).add(self.v.cross(t))
    }
    /// Its axes.
    #[inline(always)]
    pub fn x(self) -> Wide3<L> {
        let (v, w, two) = (self.v, self.w, L::splat(2.0));
        Wide3::new(
            L::splat(1.0) - two * (v.y * v.y + v.z * v.z),
            two * (v.x * v.y + w * v.z),
            two * (v.x * v.z - w * v.y),
        )
    }
    #[inline(always)]
    pub fn y(self) -> Wide3<L> {
        let (v, w, two) = (self.v, self.w, L::splat(2.0));
        Wide3::new(
            two * (v.x * v.y - w * v.z),
            L::splat(1.0) - two * (v.x * v.x + v.z * v.z),
            two * (v.y * v.z + w * v.x),
        )
    }
    #[inline(always)]
    pub fn z(self) -> Wide3<L> {
        let (v, w, two) = (self.v, self.w, L::splat(2.0));
        Wide3::new(
            two * (v.x * v.z + w * v.y),
            two * (v.y * v.z - w * v.x),
            L::splat(1.0) - two * (v.x * v.x + v.y * v.y),
        )
    }
    /// The same rotation with w ≥ 0.
    #[inline(always)]
    pub fn shorter(self) -> Self {
        let s = L::select(self.w.lt(L::zero()), L::splat(-1.0), L::splat(1.0));
        Self { v: self.v.scale(s), w: self.w * s }
    }
    #[inline(always)]
    pub fn normalized(self) -> Self {
        let inv = L::splat(1.0) / (self.v.dot(self.v) + self.w * self.w).sqrt();
        Self { v: self.v.scale(inv), w: self.w * inv }
    }
    /// The rotation vector; w ≥ 0.
    #[inline(always)]
    pub fn rotation_vector(self) -> Wide3<L> {
        let one = L::splat(1.0);
        let t2 = self.v.dot(self.v) / ((one + self.w) * (one + self.w));
        self.v.scale(L::splat(4.0) * atan_over(t2) / (one + self.w))
    }
    /// R T Rᵀ.
    #[inline(always)]
    pub fn turn(self, t: Sym<L>) -> Sym<L> {
        let (x, y, z) = (self.x(), self.y(), self.z());
        // Rows of R are (x.x, y.x, z.x), …; T times each of them.
        let r = [Wide3::new(x.x, y.x, z.x), Wide3::new(x.y, y.y, z.y), Wide3::new(x.z, y.z, z.z)];
        let (t0, t1, t2) = (t.times(r[0]), t.times(r[1]), t.times(r[2]));
        Sym {
            xx: r[0].dot(t0),
            yy: r[1].dot(t1),
            zz: r[2].dot(t2),
            xy: r[0].dot(t1),
            xz: r[0].dot(t2),
            yz: r[1].dot(t2),
        }
    }
}

/// The turn by a rotation vector, rational as the integrator has it; more than 1.2 rad are cut off.
#[inline(always)]
pub(crate) fn turned<L: Lanes>(r: Wide3<L>, q: WideQuat<L>) -> WideQuat<L> {
    let x2 = (r.dot(r) * L::splat(0.25)).min(L::splat(0.36));
    let f = L::splat(0.5) * (L::splat(15.0) - x2) / (L::splat(15.0) - L::splat(6.0) * x2);
    WideQuat { v: r.scale(f), w: L::splat(1.0) }.normalized().times(q)
}

/// atan t / t for t² ≤ 1, by t²: Chebyshev fit, within 1e-7.
#[inline(always)]
fn atan_over<L: Lanes>(t2: L) -> L {
    let mut p = L::splat(ATAN[7]);
    for c in ATAN[..7].iter().rev() {
        p = p * t2 + L::splat(*c);
    }
    p
}

/// 2 atan(y / x) for y ≥ 0, x ≥ 0, not both 0.
#[inline(always)]
pub(crate) fn twice_atan<L: Lanes>(y: L, x: L) -> L {
    let steep = y.gt(x);
    let (low, high) = (y.min(x), y.max(x));
    let t = low / L::select(high.gt(L::zero()), high, L::splat(1.0));
    let a = t * atan_over(t * t) * L::splat(2.0);
    L::select(steep, L::splat(core::f32::consts::PI) - a, a)
}

const ATAN: [f32; 8] = [
    0.999_999_9,
    -0.333_319_6,
    0.199_692_35,
    -0.140_165_85,
    0.099_060_97,
    -0.059_367_1,
    0.024_166_19,
    -0.004_668_773,
];

/// Part of a block's trace that is added to its diagonal.
pub(crate) const EASE: f32 = 1e-5;

/// A symmetric matrix per lane.
#[derive(Clone, Copy)]
pub(crate) struct Sym<L> {
    pub xx: L,
    pub yy: L,
    pub zz: L,
    pub xy: L,
    pub xz: L,
    pub yz: L,
}

impl<L: Lanes> Sym<L> {
    #[inline(always)]
    pub fn load(t: &[Lane; 6], at: usize) -> Self {
        let [xx, yy, zz, xy, xz, yz] = six(
            #[inline(always)]
            |i: usize| L::load(&t[i][at..]),
        );
        Self { xx, yy, zz, xy, xz, yz }
    }
    #[inline(always)]
    pub fn store(self, t: &mut [Lane; 6], at: usize) {
        for (to, from) in t.iter_mut().zip([self.xx, self.yy, self.zz, self.xy, self.xz, self.yz]) {
            from.store(&mut to[at..]);
        }
    }
    #[inline(always)]
    pub fn plus(self, o: Self) -> Self {
        Self {
            xx: self.xx + o.xx,
            yy: self.yy + o.yy,
            zz: self.zz + o.zz,
            xy: self.xy + o.xy,
            xz: self.xz + o.xz,
            yz: self.yz + o.yz,
        }
    }
    #[inline(always)]
    pub fn times(self, v: Wide3<L>) -> Wide3<L> {
        Wide3::new(
            self.xx * v.x + self.xy * v.y + self.xz * v.z,
            self.xy * v.x + self.yy * v.y + self.yz * v.z,
            self.xz * v.x + self.yz * v.y + self.zz * v.z,
        )
    }
    /// (r×) T (r×)ᵀ: how a point at the lever r gives way where turns do by T.
    #[inline(always)]
    pub fn moved_to(self, r: Wide3<L>) -> Self {
        // Rows of [r]: (0, −z, y), (z, 0, −x), (−y, x, 0); T times each of them.
        let tx = Wide3::new(
            self.xz * r.y - self.xy * r.z,
            self.yz * r.y - self.yy * r.z,
            self.zz * r.y - self.yz * r.z,
        );
        let ty = Wide3::new(
            self.xx * r.z - self.xz * r.x,
            self.xy * r.z - self.yz * r.x,
            self.xz * r.z - self.zz * r.x,
        );
        let (zx, zy) = (self.xy * r.x - self.xx * r.y, self.yy * r.x - self.xy * r.y);
        Self {
            xx: tx.z * r.y - tx.y * r.z,
            yy: ty.x * r.z - ty.z * r.x,
            zz: zy * r.x - zx * r.y,
            xy: tx.x * r.z - tx.z * r.x,
            xz: tx.y * r.x - tx.x * r.y,
            yz: ty.y * r.x - ty.x * r.y,
        }
    }
    #[inline(always)]
    pub fn scale(self, k: L) -> Self {
        Self {
            xx: self.xx * k,
            yy: self.yy * k,
            zz: self.zz * k,
            xy: self.xy * k,
            xz: self.xz * k,
            yz: self.yz * k,
        }
    }
    #[inline(always)]
    pub fn trace(self) -> L {
        self.xx + self.yy + self.zz
    }
    /// 1 − n nᵀ.
    #[inline(always)]
    pub fn across(n: Wide3<L>) -> Self {
        let one = L::splat(1.0);
        Self {
            xx: one - n.x * n.x,
            yy: one - n.y * n.y,
            zz: one - n.z * n.z,
            xy: -(n.x * n.y),
            xz: -(n.x * n.z),
            yz: -(n.y * n.z),
        }
    }
    /// r² − r rᵀ.
    #[inline(always)]
    pub fn around(r: Wide3<L>) -> Self {
        Self {
            xx: r.y * r.y + r.z * r.z,
            yy: r.x * r.x + r.z * r.z,
            zz: r.x * r.x + r.y * r.y,
            xy: -(r.x * r.y),
            xz: -(r.x * r.z),
            yz: -(r.y * r.z),
        }
    }
    #[inline(always)]
    pub fn select(mask: L::Mask, yes: Self, no: Self) -> Self {
        Self {
            xx: L::select(mask, yes.xx, no.xx),
            yy: L::select(mask, yes.yy, no.yy),
            zz: L::select(mask, yes.zz, no.zz),
            xy: L::select(mask, yes.xy, no.xy),
            xz: L::select(mask, yes.xz, no.xz),
            yz: L::select(mask, yes.yz, no.yz),
        }
    }
    /// T⁻¹; 0 where T is singular.
    #[inline(always)]
    pub fn inverse(self) -> Self {
        let a = self.yy * self.zz - self.yz * self.yz;
        let b = self.xz * self.yz - self.xy * self.zz;
        let c = self.xy * self.yz - self.xz * self.yy;
        let inv = inverse(self.xx * a + self.xy * b + self.xz * c);
        let d = self.xx * self.zz - self.xz * self.xz;
        let e = self.xy * self.xz - self.xx * self.yz;
        let f = self.xx * self.yy - self.xy * self.xy;
        Sym { xx: a, yy: d, zz: f, xy: b, xz: c, yz: e }.scale(inv)
    }
    /// With [`EASE`] of its trace on the diagonal: what is left along a lever of hundreds of metres is rounding in f32, of either sign, and
    /// a row that yields by so little is as good.
    #[inline(always)]
    pub fn eased(self) -> Self {
        let e = self.trace() * L::splat(EASE);
        Self { xx: self.xx + e, yy: self.yy + e, zz: self.zz + e, ..self }
    }
    /// T⁻¹ v; 0 where T is singular.
    #[inline(always)]
    pub fn solve(self, v: Wide3<L>) -> Wide3<L> {
        self.inverse().times(v)
    }
}

/// 1/x, or 0 where x is not positive.
#[inline(always)]
pub(crate) fn inverse<L: Lanes>(x: L) -> L {
    let ok = x.gt(L::zero());
    L::select(ok, L::splat(1.0) / L::select(ok, x, L::splat(1.0)), L::zero())
}

#[inline(always)]
pub(crate) fn clamped<L: Lanes>(x: L, most: L) -> L {
    x.max(-most).min(most)
}

#[inline(always)]
pub(crate) fn bounded<L: Lanes>(v: Wide3<L>, most: L) -> Wide3<L> {
    Wide3::new(clamped(v.x, most), clamped(v.y, most), clamped(v.z, most))
}

#[inline(always)]
pub(crate) fn select3<L: Lanes>(mask: L::Mask, yes: Wide3<L>, no: Wide3<L>) -> Wide3<L> {
    Wide3::new(L::select(mask, yes.x, no.x), L::select(mask, yes.y, no.y), L::select(mask, yes.z, no.z))
}

#[inline(always)]
pub(crate) fn zero3<L: Lanes>() -> Wide3<L> {
    Wide3::new(L::zero(), L::zero(), L::zero())
}

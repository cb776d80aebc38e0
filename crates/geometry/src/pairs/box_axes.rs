//! The axis that decides about two boxes, several pairs at a time.
//!
//! The fifteen candidate axes are the face normals of A (columns of I) and of B (columns of R, the rotation of B in A's
//! frame) and their nine cross products. On an axis L the gap is (|p·L| − r_A − r_B)/|L|, with p the centre of B and r
//! the half widths Σ hᵢ|L·axisᵢ|; the largest gap decides (S. Gottschalk, M. Lin, D. Manocha, "OBBTree", 1996).
//!
//! Faces win over edges, A's faces over B's, and last step's axis over the others, unless the other is better by
//! `tolerance`: faces give up to four points and a stack must not change its mind from step to step.

use super::wide::{PairRow, Pairs};
use jounce_lanes::{Kernel, LANES_MAX, Lanes, Mask, Wide3, Width, dispatch};
use jounce_math::{Pose, Vec3, scalar::f32s};

/// What decides about two boxes. Axes are numbered: 0 to 2 are faces of A, 3 to 5 faces of B, 6 + 3 i + j edges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct BoxAxis {
    /// `None`: they are farther apart than the margin.
    pub number: Option<u32>,
    /// Along the axis, m, where it is an edge's or where they are apart.
    pub gap: f32,
}

/// The pair of two boxes by their half extents. The last axis, if there is one, is favoured.
pub(super) fn row([ha, hb]: [Vec3; 2], pose: &Pose, margin: f32, known: Option<u32>) -> PairRow {
    PairRow::new(pose, margin, ha, hb, known.map_or(-1.0, |k| k as f32))
}

/// By how much, m, an axis must be better than those before it.
pub(super) fn tolerance(ha: Vec3, hb: Vec3) -> f32 {
    f32s::min(1e-3 * f32s::min(ha.min_component(), hb.min_component()), 5e-4)
}

/// The axis of every pair.
///
/// # Panics
/// Where `axes` is not as long as `rows`.
pub(super) fn find(width: Width, rows: &[PairRow], axes: &mut [BoxAxis]) {
    assert_eq!(rows.len(), axes.len(), "a place for each axis");
    dispatch(width, Find { rows, axes });
}

struct Find<'a> {
    rows: &'a [PairRow],
    axes: &'a mut [BoxAxis],
}

impl Kernel for Find<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        for (rows, axes) in self.rows.chunks(L::WIDTH).zip(self.axes.chunks_mut(L::WIDTH)) {
            let (mut numbers, mut gaps) = ([0.0; LANES_MAX], [0.0; LANES_MAX]);
            let (number, gap) = best(&Pairs::<L>::load(rows));
            number.store(&mut numbers);
            gap.store(&mut gaps);
            for ((axis, number), &gap) in axes.iter_mut().zip(numbers).zip(&gaps) {
                *axis = BoxAxis { number: (number >= 0.0).then_some(number as u32), gap };
            }
        }
    }
}

/// Number, or −1, and gap.
#[inline(always)]
fn best<L: Lanes>(pairs: &Pairs<L>) -> (L, L) {
    let Pairs { p, q, margin, a: ha, b: hb, known } = pairs;
    let zero = L::zero();
    let r = q.columns();
    let abs = [r[0].abs(), r[1].abs(), r[2].abs()];
    let along = abs[0].scale(hb.x).add(abs[1].scale(hb.y)).add(abs[2].scale(hb.z));
    let gaps_a = components(p.abs().sub(*ha).sub(along));
    let pb = Wide3::new(r[0].dot(*p), r[1].dot(*p), r[2].dot(*p));
    let across = Wide3::new(abs[0].dot(*ha), abs[1].dot(*ha), abs[2].dot(*ha));
    let gaps_b = components(pb.abs().sub(*hb).sub(across));
    let [most_a, most_b] = [most(gaps_a), most(gaps_b)];
    let (apart_a, apart_b) = (most_a.gt(*margin), most_b.gt(*margin));
    let (apart, part) = (apart_a | apart_b, L::select(apart_a, most_a, most_b));
    let none = L::splat(-1.0);
    if !(!apart).any() {
        return (none, part);
    }
    let thinnest = least(components(*ha)).min(least(components(*hb)));
    let tolerance = (L::splat(1e-3) * thinnest).min(L::splat(5e-4));
    let (mut number, mut gap) = (zero, gaps_a[0] + bonus(*known, 0, tolerance));
    for (axis, s) in [gaps_a[1], gaps_a[2], gaps_b[0], gaps_b[1], gaps_b[2]].into_iter().enumerate() {
        let s = s + bonus(*known, axis + 1, tolerance);
        let better = s.gt(gap + tolerance * L::splat(0.5));
        number = L::select(better, L::splat((axis + 1) as f32), number);
        gap = L::select(better, s, gap);
    }
    // What an edge has to beat.
    gap = gap + tolerance;
    let (mut is_edge, mut edge) = (zero.gt(zero), zero);
    let (h, p) = (components(*ha), components(*p));
    let hb = components(*hb);
    let axes = [components(r[0]), components(r[1]), components(r[2])];
    let sizes = [components(abs[0]), components(abs[1]), components(abs[2])];
    for j in 0..3 {
        let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
        let c = axes[j];
        for i in 0..3 {
            let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
            let reach =
                h[i1] * sizes[j][i2] + h[i2] * sizes[j][i1] + hb[j1] * sizes[j2][i] + hb[j2] * sizes[j1][i];
            let s = (p[i2] * c[i1] - p[i1] * c[i2]).abs() - reach;
            // |L| ≤ 1, so a negative gap only gets deeper by the division; parallel edges have no axis.
            let l2 = c[i1] * c[i1] + c[i2] * c[i2];
            let worse = s.lt(zero) & s.le(gap - tolerance);
            let may = !(worse | l2.lt(L::splat(1e-5)));
            let s = s / l2.sqrt();
            let favoured = s + bonus(*known, 6 + 3 * i + j, tolerance);
            let better = may & favoured.gt(gap);
            number = L::select(better, L::splat((6 + 3 * i + j) as f32), number);
            gap = L::select(better, favoured, gap);
            edge = L::select(better, s, edge);
            is_edge = is_edge | better;
        }
    }
    let apart_edge = is_edge & edge.gt(*margin);
    let gap = L::select(apart, part, edge);
    (L::select(apart | apart_edge, none, number), gap)
}

/// What the last test's axis is favoured by.
#[inline(always)]
fn bonus<L: Lanes>(known: L, axis: usize, tolerance: L) -> L {
    L::select(known.eq(L::splat(axis as f32)), tolerance, L::zero())
}

#[inline(always)]
fn components<L: Lanes>(v: Wide3<L>) -> [L; 3] {
    [v.x, v.y, v.z]
}

#[inline(always)]
fn most<L: Lanes>([x, y, z]: [L; 3]) -> L {
    x.max(y).max(z)
}

#[inline(always)]
fn least<L: Lanes>([x, y, z]: [L; 3]) -> L {
    x.min(y).min(z)
}

//! Two bodies whose anchors are one point, per lane; equations and symbols are in the text of [`super`].

use super::solve::Constants;
use crate::room::contacts::rows::{LANES, LaneVec, Wide3};
use crate::room::joints::lanes::{Sym, WideQuat, bounded, select3};
use crate::room::joints::set::CALMING;
use crate::room::rigid::state::BodyState;
use jounce_lanes::{Lanes, Mask};
use jounce_tasks::Scatter;

/// How bodies turn.
pub(super) trait Turns<L>: Copy {
    /// I⁻¹ v.
    fn times(self, v: Wide3<L>) -> Wide3<L>;
    /// (r×) I⁻¹ (r×)ᵀ: how a point at the lever r gives way.
    fn moved_to(self, r: Wide3<L>) -> Sym<L>;
}

impl<L: Lanes> Turns<L> for Sym<L> {
    #[inline(always)]
    fn times(self, v: Wide3<L>) -> Wide3<L> {
        self.times(v)
    }
    #[inline(always)]
    fn moved_to(self, r: Wide3<L>) -> Sym<L> {
        self.moved_to(r)
    }
}

/// The same about all axes.
#[derive(Clone, Copy)]
pub(super) struct Round<L>(pub L);

impl<L: Lanes> Turns<L> for Round<L> {
    #[inline(always)]
    fn times(self, v: Wide3<L>) -> Wide3<L> {
        v.scale(self.0)
    }
    #[inline(always)]
    fn moved_to(self, r: Wide3<L>) -> Sym<L> {
        Sym::around(r).scale(self.0)
    }
}

/// Velocities of the two bodies of a joint, and where they are.
#[derive(Clone, Copy)]
pub(super) struct Two<L, T> {
    va: Wide3<L>,
    pub wa: Wide3<L>,
    vb: Wide3<L>,
    pub wb: Wide3<L>,
    /// Their places along x and y, which lie beside the velocities.
    pa: [L; 2],
    pb: [L; 2],
    ma: L,
    mb: L,
    pub ta: T,
    pub tb: T,
    pub ra: Wide3<L>,
    pub rb: Wide3<L>,
    /// From anchor to anchor.
    pub d: Wide3<L>,
}

impl<L: Lanes, T: Turns<L>> Two<L, T> {
    /// Velocities of the bodies of rows `row..` of the colour, one per lane, their inverse masses and how they turn. Lanes past the last row read a
    /// body at rest.
    #[inline(always)]
    pub fn load(access: &Scatter<'_, BodyState>, row: usize, [ma, mb]: [L; 2], [ta, tb]: [T; 2]) -> Self {
        let bodies = access.gather::<LANES>(row, L::WIDTH);
        let a = L::gather8(
            #[inline(always)]
            |i| &bodies[i][0].hot,
        );
        let b = L::gather8(
            #[inline(always)]
            |i| &bodies[i][1].hot,
        );
        let zero = Wide3::new(L::zero(), L::zero(), L::zero());
        Self {
            va: Wide3::new(a[0], a[1], a[2]),
            wa: Wide3::new(a[3], a[4], a[5]),
            vb: Wide3::new(b[0], b[1], b[2]),
            wb: Wide3::new(b[3], b[4], b[5]),
            pa: [a[6], a[7]],
            pb: [b[6], b[7]],
            ma,
            mb,
            ta,
            tb,
            ra: zero,
            rb: zero,
            d: zero,
        }
    }

    /// Levers, and from anchor to anchor.
    #[inline(always)]
    pub fn stands(&mut self, [ra, rb, d]: [Wide3<L>; 3]) {
        (self.ra, self.rb, self.d) = (ra, rb, d);
    }

    /// Levers and anchor to anchor where the bodies have moved to, from those of the step's start; gives how both have turned since.
    #[inline(always)]
    pub fn follow(
        &mut self,
        access: &Scatter<'_, BodyState>,
        row: usize,
        [ra, rb, offset]: [&LaneVec; 3],
        at: usize,
    ) -> [WideQuat<L>; 2] {
        let bodies = access.gather::<LANES>(row, L::WIDTH);
        let x = L::gather8(
            #[inline(always)]
            |i| &bodies[i][0].motion,
        );
        let y = L::gather8(
            #[inline(always)]
            |i| &bodies[i][1].motion,
        );
        let da = WideQuat { v: Wide3::new(x[4], x[5], x[6]), w: x[7] };
        let db = WideQuat { v: Wide3::new(y[4], y[5], y[6]), w: y[7] };
        let [pa, pb] = [Wide3::new(self.pa[0], self.pa[1], x[0]), Wide3::new(self.pb[0], self.pb[1], y[0])];
        (self.ra, self.rb) = (da.rotate(Wide3::load(ra, at)), db.rotate(Wide3::load(rb, at)));
        self.d = Wide3::load(offset, at).add(pb.sub(pa)).add(self.rb.sub(self.ra));
        [da, db]
    }

    #[inline(always)]
    pub fn store(self, access: &mut Scatter<'_, BodyState>, row: usize) {
        let mut bodies = access.gather_mut::<LANES>(row, L::WIDTH);
        let (v, w, p) = (self.va, self.wa, self.pa);
        L::scatter8(
            [v.x, v.y, v.z, w.x, w.y, w.z, p[0], p[1]],
            #[inline(always)]
            |i, hot| {
                if let Some(body) = &mut bodies[i][0] {
                    body.hot = hot;
                }
            },
        );
        let (v, w, p) = (self.vb, self.wb, self.pb);
        L::scatter8(
            [v.x, v.y, v.z, w.x, w.y, w.z, p[0], p[1]],
            #[inline(always)]
            |i, hot| {
                if let Some(body) = &mut bodies[i][1] {
                    body.hot = hot;
                }
            },
        );
    }

    /// An impulse at the point, on B.
    #[inline(always)]
    pub fn push(&mut self, p: Wide3<L>) {
        self.give(p, [self.ta.times(self.ra.cross(p)), self.tb.times(self.rb.cross(p))]);
    }
    /// The same with the changes of spin that go with it.
    #[inline(always)]
    fn give(&mut self, p: Wide3<L>, [wa, wb]: [Wide3<L>; 2]) {
        self.va = self.va.sub(p.scale(self.ma));
        self.wa = self.wa.sub(wa);
        self.vb = self.vb.add(p.scale(self.mb));
        self.wb = self.wb.add(wb);
    }
    /// A moment on B.
    #[inline(always)]
    pub fn turn(&mut self, l: Wide3<L>) {
        self.wa = self.wa.sub(self.ta.times(l));
        self.wb = self.wb.add(self.tb.times(l));
    }
    /// Speed of the anchors against each other.
    #[inline(always)]
    fn slip(&self) -> Wide3<L> {
        self.vb.add(self.wb.cross(self.rb)).sub(self.va.add(self.wa.cross(self.ra)))
    }

    /// Holds the anchors together; from the impulse so far to the one after it.
    #[inline(always)]
    pub fn hold(&mut self, old: Wide3<L>, k: &Constants, solving: bool) -> Wide3<L> {
        let (scale, rate, fade) = softness::<L>(k, solving);
        let mut v = self.slip();
        if solving {
            v = v.add(bounded(self.d, L::splat(k.correct)).scale(rate));
        }
        let mut m = self.ta.moved_to(self.ra).plus(self.tb.moved_to(self.rb));
        let both = self.ma + self.mb;
        (m.xx, m.yy, m.zz) = (m.xx + both, m.yy + both, m.zz + both);
        let mut change = m.eased().solve(v).scale(-scale);
        if solving {
            change = change.sub(old.scale(fade));
        }
        let [wa, wb] = [self.ta.times(self.ra.cross(change)), self.tb.times(self.rb.cross(change))];
        // The part that changes neither body by more than a pass may: nearly always all of it.
        let (m, most) = (self.ma.max(self.mb), L::splat(k.speed_max));
        let over = change.dot(change) * (m * m) / (most * most);
        if is_bearable(over, wa, wb, k) {
            self.give(change, [wa, wb]);
        } else {
            let part = within(over).min(bearable_turn(wa, wb, k));
            change = change.scale(part);
            self.push(change);
        }
        old.add(change)
    }

    /// Velocities as before in the lanes that are not meant.
    #[inline(always)]
    pub fn keep(&mut self, meant: L::Mask, before: &Self) {
        self.va = select3(meant, self.va, before.va);
        self.wa = select3(meant, self.wa, before.wa);
        self.vb = select3(meant, self.vb, before.vb);
        self.wb = select3(meant, self.wb, before.wb);
    }

    /// Draws the velocities of two whose points are torn apart towards their mean, as sets do: rows with such levers are no longer
    /// linear in a substep, and would drive the bodies round for ever.
    #[inline(always)]
    pub fn calm(&mut self, k: &Constants) {
        let both = self.ma.min(self.mb).gt(L::zero());
        let torn = self.d.dot(self.d).gt(L::splat(k.torn * k.torn)) & both;
        if !torn.any() {
            return;
        }
        let part = L::select(torn, L::splat(CALMING), L::zero());
        let sum = L::select(both, self.ma + self.mb, L::splat(1.0));
        let v = self.vb.sub(self.va).scale(part / sum);
        self.va = self.va.add(v.scale(self.ma));
        self.vb = self.vb.sub(v.scale(self.mb));
        self.wa = self.wa.sub(self.wa.scale(part));
        self.wb = self.wb.sub(self.wb.scale(part));
    }
}

/// The part of two changes of spin that a pass may make.
#[inline(always)]
pub(super) fn bearable_turn<L: Lanes>(wa: Wide3<L>, wb: Wide3<L>, k: &Constants) -> L {
    let most = L::splat(k.spin_max);
    within(wa.dot(wa).max(wb.dot(wb)) / (most * most))
}

/// May all lanes take the whole of it? Then the parts are 1.
#[inline(always)]
fn is_bearable<L: Lanes>(over: L, wa: Wide3<L>, wb: Wide3<L>, k: &Constants) -> bool {
    let most = L::splat(k.spin_max);
    let turn = wa.dot(wa).max(wb.dot(wb));
    (over.le(L::splat(1.0)) & turn.le(most * most)).all()
}

/// What a square that should not pass 1 is scaled down by; 0 where it is not finite.
#[inline(always)]
fn within<L: Lanes>(over: L) -> L {
    let (zero, one) = (L::zero(), L::splat(1.0));
    let part = one / over.max(one).sqrt();
    L::select((over * zero).eq(zero), part, zero)
}

#[inline(always)]
pub(super) fn softness<L: Lanes>(k: &Constants, solving: bool) -> (L, L, L) {
    if solving {
        (L::splat(k.soft.mass_scale), L::splat(k.soft.bias_rate), L::splat(k.soft.impulse_scale))
    } else {
        (L::splat(1.0), L::zero(), L::zero())
    }
}

//! The passes of a substep over a band; see [`super::super::set`] for what they are for.

use super::kernels::{Account, Aim, Damp, Gain, Move, Push, Refresh, Spin, Stiffen, Take, Try};
use super::matrix::Factor;
use super::{Band, Z};
use crate::room::contacts::rows::{LANES, Lane};
use crate::room::joints::active::{BEND, ROUNDS_OF_ENDS};
use crate::room::joints::place::{BEYOND, GAP, NEAR, OPEN, PLACINGS};
use crate::room::joints::set::{CALMING, Constants, TORN};
use crate::room::rigid::state::BodyState;
use jounce_lanes::{Width, dispatch};
use jounce_math::Vec3;

/// Which pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pass {
    /// Before the positions move: once before and once after contacts.
    Solve,
    /// The same as if the way of the substep were straight.
    Straight,
    /// Places alone: a velocity is a way, and the substep lasts a second.
    Place,
    /// After they moved.
    Relax,
}

impl Pass {
    pub(super) fn looks_ahead(self) -> bool {
        self == Self::Solve
    }
}

/// Rounds of the active set; the second half of them lets none in, and so ends.
const ROUNDS: usize = 2 * ROUNDS_OF_ENDS;
/// The way that ends Newton's steps, m or rad: what f32 can tell.
const PLACED: f32 = 1e-5;

impl Band {
    /// Before the positions move.
    pub fn solve(&mut self, width: Width, states: &[BodyState], k: &Constants, first: bool) {
        self.placed = [false; LANES];
        self.wake();
        dispatch(width, Take { band: self, states });
        if first {
            self.any_stiff = dispatch(width, Stiffen { band: self, h: k.h });
            self.refresh(width);
        }
        if self.any_stiff {
            dispatch(width, Damp(self));
        }
        for j in &mut self.joints {
            for row in &mut j.rows {
                row.lambda = Z;
            }
        }
        if self.any_pull || self.any_drive {
            dispatch(width, Push { band: self, first: true, warm: k.warm });
        }
        self.hold(width, k);
        dispatch(width, Gain(self));
    }

    /// Lanes whose velocities contacts have changed since; tells whether there are any.
    pub fn touched(&mut self, states: &[BodyState]) -> bool {
        self.live = Z;
        for b in &self.bodies {
            for (l, live) in self.live.iter_mut().enumerate() {
                let Some(s) = states.get(b.rows[l] as usize) else { continue };
                if s.v() != b.v.get(l) || s.w() != b.w.get(l) {
                    *live = 1.0;
                }
            }
        }
        self.live != Z
    }

    /// Before the positions move, after contacts, in the lanes that [`Band::touched`] found.
    pub fn answer(&mut self, width: Width, states: &[BodyState], k: &Constants) {
        dispatch(width, Take { band: self, states });
        if self.any_drive {
            dispatch(width, Push { band: self, first: false, warm: k.warm });
        }
        self.hold(width, k);
        dispatch(width, Gain(self));
    }

    /// After they moved.
    pub fn relax(&mut self, width: Width, states: &[BodyState], k: &Constants) {
        self.placed = [false; LANES];
        self.wake();
        dispatch(width, Take { band: self, states });
        self.refresh(width);
        let placed = self.turn_back(width, k);
        self.any_stiff = dispatch(width, Stiffen { band: self, h: k.h });
        if self.any_stiff || placed {
            self.refresh(width);
        }
        if self.any_drive {
            dispatch(width, Push { band: self, first: false, warm: k.warm });
        }
        self.rounds(width, Pass::Relax, k);
        let torn = self.open(TORN * k.correct);
        for l in (0..LANES).filter(|&l| torn[l]) {
            self.calm(l);
        }
        dispatch(width, Account { band: self, h: k.h });
        dispatch(width, Gain(self));
    }

    fn wake(&mut self) {
        self.live = Z;
        self.live[..self.sets.len()].fill(1.0);
    }

    fn refresh(&mut self, width: Width) {
        dispatch(width, Refresh(self));
        self.fresh = Z;
    }

    /// Where the way of the substep bends much, that is judged only once the velocities fit the joints (see [`super::super::active`]).
    fn hold(&mut self, width: Width, k: &Constants) {
        let live = self.live;
        dispatch(width, Aim { band: self, pass: Pass::Solve, k });
        self.live = self.bends(k);
        if self.live != Z {
            self.rounds(width, Pass::Straight, k);
            self.live = live;
            dispatch(width, Aim { band: self, pass: Pass::Solve, k });
        }
        self.live = live;
        self.go_round(width, Pass::Solve, k);
    }

    /// 1 in lanes in which the way of some point bends by more than [`BEND`] in the substep.
    fn bends(&self, k: &Constants) -> Lane {
        let mut lanes = Z;
        let most = BEND * k.correct;
        for (j, link) in self.joints.iter().zip(&self.pattern.joints) {
            let (holds, _) = link.kind.turns();
            for row in &j.rows[..3 + holds] {
                for (lane, curve) in lanes.iter_mut().zip(&row.curve) {
                    if curve.abs() > most {
                        *lane = 1.0;
                    }
                }
            }
        }
        for (lane, live) in lanes.iter_mut().zip(&self.live) {
            *lane *= live;
        }
        lanes
    }

    fn rounds(&mut self, width: Width, pass: Pass, k: &Constants) {
        dispatch(width, Aim { band: self, pass, k });
        self.go_round(width, pass, k);
    }

    /// The active set, once all rows have their right sides.
    fn go_round(&mut self, width: Width, pass: Pass, k: &Constants) {
        for round in 1..=ROUNDS {
            dispatch(width, Factor(self));
            let lets_in = round <= ROUNDS_OF_ENDS;
            dispatch(width, Try { band: self, pass, k, lets_in, last: round == ROUNDS });
            if self.live == Z {
                return;
            }
        }
    }

    /// Sets with a point that is further off than that along some axis.
    fn open(&self, most: f32) -> [bool; LANES] {
        let mut open = [false; LANES];
        for row in self.joints.iter().flat_map(|j| &j.rows[..3]) {
            for (open, c) in open.iter_mut().zip(&row.c) {
                *open |= c.abs() > most;
            }
        }
        open
    }

    /// Ends of turns that the motion passed are put back at once, and points that it parted (see [`super::super::place`]).
    fn turn_back(&mut self, width: Width, k: &Constants) -> bool {
        let mut gone = self.open(GAP * k.correct);
        for (j, link) in self.joints.iter().zip(&self.pattern.joints) {
            let (holds, ends) = link.kind.turns();
            for row in &j.rows[3 + holds..3 + holds + ends] {
                for (gone, c) in gone.iter_mut().zip(&row.c) {
                    *gone |= *c < -BEYOND;
                }
            }
        }
        let lost = self.open(OPEN * k.correct);
        for l in 0..LANES {
            gone[l] &= !lost[l] && l < self.sets.len();
        }
        if !gone.contains(&true) {
            return false;
        }
        self.keep();
        dispatch(width, Spin { band: self, back: None });
        self.placed = self.place(width, &gone, k);
        self.recall();
        let back = self.placed.map(|p| f32::from(u8::from(p)));
        dispatch(width, Spin { band: self, back: Some(&back) });
        self.wake();
        true
    }

    /// Newton's steps in which C = 0, in these lanes; tells where they came to rest.
    fn place(&mut self, width: Width, lanes: &[bool; LANES], k: &Constants) -> [bool; LANES] {
        let k = Constants {
            h: 1.0,
            push_out: f32::INFINITY,
            correct: f32::INFINITY,
            speed_max: f32::INFINITY,
            spin_max: core::f32::consts::TAU,
            ..*k
        };
        let mut left = *lanes;
        let mut last = [f32::INFINITY; LANES];
        for step in 0..PLACINGS {
            for b in &mut self.bodies {
                (b.v.0, b.w.0) = ([Z; 3], [Z; 3]);
            }
            for row in self.joints.iter_mut().flat_map(|j| &mut j.rows) {
                row.lambda = Z;
            }
            if step > 0 {
                self.refresh(width);
            }
            self.live = Z;
            for (live, left) in self.live.iter_mut().zip(&left) {
                *live = f32::from(u8::from(*left));
            }
            self.rounds(width, Pass::Place, &k);
            let mut way: Lane = Z;
            dispatch(width, Move { band: self, way: &mut way });
            for ((left, last), way) in left.iter_mut().zip(&mut last).zip(way) {
                if *left {
                    *last = way;
                    *left = way >= PLACED * PLACED;
                }
            }
            if !left.contains(&true) {
                break;
            }
        }
        core::array::from_fn(|l| lanes[l] && last[l] < NEAR * NEAR)
    }

    fn keep(&mut self) {
        for b in &mut self.bodies {
            (b.kept_dp, b.kept_dr, b.kept_dq) = (b.dp, b.dr, b.dq);
        }
        for row in self.joints.iter_mut().flat_map(|j| &mut j.rows) {
            row.kept = [row.lambda, row.acts];
        }
    }

    /// Velocities and impulses as before; places too but where new ones were found.
    fn recall(&mut self) {
        let found = self.placed;
        for b in &mut self.bodies {
            (b.v, b.w) = (b.v0, b.w0);
            for l in (0..LANES).filter(|&l| !found[l]) {
                for i in 0..3 {
                    b.dp.0[i][l] = b.kept_dp.0[i][l];
                    b.dr.0[i][l] = b.kept_dr.0[i][l];
                }
                for i in 0..4 {
                    b.dq[i][l] = b.kept_dq[i][l];
                }
            }
        }
        for row in self.joints.iter_mut().flat_map(|j| &mut j.rows) {
            [row.lambda, row.acts] = row.kept;
        }
    }

    /// Draws the velocities of a torn set towards that of its centre of mass.
    fn calm(&mut self, l: usize) {
        let (mut p, mut mass) = (Vec3::ZERO, 0.0);
        for b in self.bodies.iter().filter(|b| b.inv_mass[l] > 0.0) {
            let m = 1.0 / b.inv_mass[l];
            p += b.v.get(l) * m;
            mass += m;
        }
        if mass <= 0.0 || !mass.is_finite() {
            return;
        }
        let mean = p / mass;
        for b in &mut self.bodies {
            let (v, w) = (b.v.get(l), b.w.get(l));
            b.v.set(l, v + (mean - v) * CALMING);
            b.w.set(l, w - w * CALMING);
        }
    }
}

//! A snowboard on its edges.
//!
//! Symbols: R_s side-cut radius, θ edge angle (of the base against the snow), a half the edge's length, N load of a station, v velocity of a
//! station over the snow, t the edge's tangent there, b across it in the snow.
//!
//! An edge set at θ touches along all its length when the board has bent to the arc R = R_s cos θ (Howe): a circle of R_s seen from
//! the snow at θ is an ellipse of that radius at its waist. So the tangents at nose and tail are turned against each other by 2a/R, and
//! the edge, which cuts along itself and not across, makes the board run on that circle. Four stations, the ends of both edges, each hold
//!
//! * up: a damped spring, N, all four solved together;
//! * across: |E| ≤ N (μ_edge − μ) min(1, sin |θ|/sin θ_e), what the snow resists to the edge; beyond it the board skids;
//! * in the snow: friction against the slip, |F| ≤ μ N. A flat board has this alone, so all its ways are alike.
//!
//! Edge and friction are velocity constraints with bounds, all stations in turn. Springs: j_i = h k δ_i + q (c_i − Σ_k A_ik j_k) ≥ 0 with
//! the closing speeds c, q = h c_d + h² k and A the velocity at one station by a unit impulse at another. (Each with a fourth of the
//! board, turning and all, it would sink deeper than m g/k: at rest nothing turns.)
//!
//! Sources: Howe, The New Skiing Mechanics, 2001; Lind & Sanders, The Physics of Skiing, 2nd ed. 2004, 3 and 4.

use super::desc::BoardDesc;
use super::solve::{KAPPA_MIN, Now, Numbers, Run, hold_roll};
use super::state::{Seen, Vehicle};
use jounce_math::{Vec3, scalar::f32s};

/// Rounds over the stations.
const ROUNDS: usize = 12;

/// Forward and left of the stations, in halves of length and width.
pub(crate) const STATIONS: [(f32, f32); 4] = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];

#[derive(Clone, Copy, Debug, Default)]
struct Work {
    arm: Vec3,
    now: Now,
    load: f32,
    t: Vec3,
    b: Vec3,
    /// Bounds of friction and edge, N s.
    most: [f32; 2],
    /// Friction along and across, and the edge's hold, so far.
    impulse: [f32; 2],
    edge: f32,
    /// 1/effective mass.
    k: [f32; 2],
}

pub(crate) fn substep(v: &mut Vehicle, d: &BoardDesc, run: &mut Run, k: &Numbers) {
    let h = k.h;
    let mut work = [Work::default(); 4];
    let touching = stand(v, d, run, k, &mut work);
    set_edges(d, run, &mut work);
    for _ in 0..ROUNDS {
        for w in work.iter_mut().filter(|w| w.load > 0.0) {
            hold(run, w);
        }
    }
    ride(v, d, run, h, &work, touching);
    for (s, w) in v.stations.iter_mut().zip(&work) {
        let slip = if w.load > 0.0 { run.over(w.arm, &w.now) } else { Vec3::ZERO };
        let along = f32s::max(slip.dot(w.t).abs(), 1e-3);
        s.seen = Seen {
            load: w.load / h,
            force: [w.impulse[0] / h, (w.impulse[1] + w.edge) / h],
            slip: [0.0, f32s::atan2(slip.dot(w.b), along)],
            friction: if w.load > 0.0 { (w.most[0] + w.most[1]) / w.load } else { 0.0 },
            normal: if w.load > 0.0 { w.now.normal } else { Vec3::ZERO },
            suspension: w.load / h,
            point: if w.load > 0.0 { run.place(w.arm) } else { s.seen.point },
            drive: 0.0,
        };
    }
}

/// Edge first, then friction: what the edge holds does not slip.
fn hold(run: &mut Run, w: &mut Work) {
    let slip = run.over(w.arm, &w.now).dot(w.b);
    let old = w.edge;
    w.edge = f32s::clamp(old - slip / w.k[1], -w.most[1], w.most[1]);
    push(run, w, w.b * (w.edge - old));
    let slip = run.over(w.arm, &w.now);
    let [x, y] = w.impulse;
    let next = [x - slip.dot(w.t) / w.k[0], y - slip.dot(w.b) / w.k[1]];
    let size = (next[0] * next[0] + next[1] * next[1]).sqrt();
    let part = if size > w.most[0] { w.most[0] / size } else { 1.0 };
    w.impulse = next.map(|j| j * part);
    push(run, w, w.t * (w.impulse[0] - x) + w.b * (w.impulse[1] - y));
}

fn push(run: &mut Run, w: &Work, j: Vec3) {
    run.chassis.push(w.arm, j);
    run.push_ground(w.arm, &w.now, j);
}

/// Loads, and jumps.
fn stand(v: &mut Vehicle, d: &BoardDesc, run: &mut Run, numbers: &Numbers, work: &mut [Work; 4]) -> usize {
    let h = numbers.h;
    let (up, _) = run.axes();
    let q = run.chassis.m.dq;
    let (k, c) = (0.25 * d.stiffness, 0.25 * d.damping);
    let q_spring = h * c + h * h * k;
    let slack = f32s::max(2.0 * run.mass * run.gravity.length() / d.stiffness, 0.1 * d.reach);
    let mut wanted = [0.0; 4];
    let mut touches = [false; 4];
    for i in 0..4 {
        let mut depth = 0.0;
        let mut way = 0.0;
        if let Some(plane) = &run.stations[i].plane {
            let now = run.now(plane);
            let arm = q.rotate(run.stations[i].hub);
            depth = (now.point - arm).dot(now.normal);
            if depth > 0.0 && now.normal.dot(up) > KAPPA_MIN {
                let over = run.over(arm, &now);
                let closing = -over.dot(now.normal);
                (work[i].arm, work[i].now) = (arm, now);
                touches[i] = true;
                let along = over + now.normal * closing;
                let along = if v.stations[i].depth > 0.0 { along.length() } else { 0.0 };
                let time = if run.stations[i].met { numbers.dt } else { h };
                way = (along + f32s::max(closing, 0.0)) * time;
                wanted[i] = q_spring * closing;
            } else {
                depth = 0.0;
            }
        }
        let entered = v.stations[i].entered(depth, way, slack, numbers.push_out_speed * h);
        wanted[i] += h * k * entered;
    }
    let count = touches.iter().filter(|t| **t).count();
    let asked = v.input.jump >= 0.5;
    let jump = if asked && !v.jumped && count > 0 { run.mass * d.jump_speed / count as f32 } else { 0.0 };
    v.jumped = asked && (v.jumped || jump > 0.0);
    let loads = loads(run, work, touches, wanted, q_spring);
    for (w, j) in work.iter_mut().zip(loads).filter(|(_, j)| *j > 0.0) {
        w.load = j;
        push(run, w, w.now.normal * (j + jump));
    }
    count
}

/// j ≥ 0 with (1 + q A) j = b where j > 0; stations that would pull let go, one round after another.
fn loads(run: &Run, work: &[Work; 4], mut on: [bool; 4], b: [f32; 4], q: f32) -> [f32; 4] {
    let mut a = [[0.0_f64; 4]; 4];
    for i in 0..4 {
        for k in (0..4).filter(|&k| on[i] && on[k]) {
            let (x, y) = (&work[i], &work[k]);
            let mut met = run.chassis.answer(x.arm, x.now.normal, y.arm, y.now.normal);
            if x.now.ground == y.now.ground {
                let lever = |w: &Work| w.now.lever + (w.arm - w.now.point);
                met += run.grounds[x.now.ground].answer(lever(x), x.now.normal, lever(y), y.now.normal);
            }
            a[i][k] = f64::from(q * met);
        }
        a[i][i] += 1.0;
    }
    for _ in 0..4 {
        let j = eliminate(a, b.map(f64::from), on);
        let pulls = |i: &usize| on[*i] && j[*i] <= 0.0;
        if !(0..4).any(|i| pulls(&i)) {
            return j.map(|j| j as f32);
        }
        for i in 0..4 {
            on[i] = on[i] && j[i] > 0.0;
        }
    }
    [0.0; 4]
}

/// Gauss; 1 + q A has pivots of at least 1.
fn eliminate(mut a: [[f64; 4]; 4], mut b: [f64; 4], on: [bool; 4]) -> [f64; 4] {
    for i in (0..4).filter(|&i| on[i]) {
        for k in (i + 1..4).filter(|&k| on[k]) {
            let f = a[k][i] / a[i][i];
            for c in (i..4).filter(|&c| on[c]) {
                a[k][c] -= f * a[i][c];
            }
            b[k] -= f * b[i];
        }
    }
    let mut x = [0.0; 4];
    for i in (0..4).rev().filter(|&i| on[i]) {
        let rest: f64 = (i + 1..4).filter(|&k| on[k]).map(|k| a[i][k] * x[k]).sum();
        x[i] = (b[i] - rest) / a[i][i];
    }
    x
}

/// Angle of the base against the snow: positive on the right edge.
fn edge_angle(up: Vec3, forward: Vec3, n: Vec3) -> f32 {
    f32s::atan2(n.dot(up.cross(forward)), n.dot(up))
}

fn set_edges(d: &BoardDesc, run: &Run, work: &mut [Work; 4]) {
    let (up, forward) = run.axes();
    for (w, place) in work.iter_mut().zip(STATIONS) {
        if w.load <= 0.0 {
            continue;
        }
        let n = w.now.normal;
        let along = (forward - n * forward.dot(n)).normalize_or(forward);
        let theta = edge_angle(up, forward, n);
        let (sin, cos) = (f32s::sin(theta), f32s::cos(theta));
        let set = f32s::min(sin.abs() / f32s::sin(d.edge_angle), 1.0);
        // Right edge: the nose's tangent turns right, the tail's left.
        let bend = 0.5 * d.length / (d.sidecut * f32s::max(cos, 0.05)) * set;
        let turn = if sin > 0.0 { -place.0 * bend } else { place.0 * bend };
        let across = n.cross(along);
        w.t = along * f32s::cos(turn) + across * f32s::sin(turn);
        w.b = n.cross(w.t);
        let edge = (f32s::max(d.edge_friction, d.friction) - d.friction) * set;
        w.most = [d.friction * w.load, edge * w.load];
        for (k, e) in w.k.iter_mut().zip([w.t, w.b]) {
            *k = f32s::max(
                run.chassis.response(w.arm, e, e) + run.ground_response(w.arm, &w.now, e, e),
                1e-20,
            );
        }
    }
}

/// Cosines of the angles from upright up to which a rider in the air has all of his balance, and from which none: 30° and 60°.
const HELD: f32 = 0.866;
const LOST: f32 = 0.5;

/// The rider's balance: the edge angle asked for on snow, upright in the air.
fn ride(v: &Vehicle, d: &BoardDesc, run: &mut Run, h: f32, work: &[Work; 4], touching: usize) {
    let (up, forward) = run.axes();
    let (mut n, mut height) = (Vec3::ZERO, 0.0);
    for w in work.iter().filter(|w| w.load > 0.0) {
        (n, height) = (n + w.now.normal, height - w.arm.dot(up));
    }
    let wanted = v.input.lean * d.lean_max;
    if touching == 0 || n == Vec3::ZERO {
        let g = run.gravity.length();
        if g > 0.0 {
            let sky = run.gravity * (-1.0 / g);
            // Head over heels there is no upright to be held, and what turned to one would whirl it about.
            let part = f32s::clamp((up.dot(sky) - LOST) / (HELD - LOST), 0.0, 1.0);
            let error = edge_angle(up, forward, sky);
            hold_roll(run, error - wanted, part * d.hertz, d.damping_ratio, 0.0, h);
        }
        return;
    }
    let theta = edge_angle(up, forward, n.normalize_or(up));
    hold_roll(run, theta - wanted, d.hertz, d.damping_ratio, height / touching as f32, h);
}

//! What an entry changes of a vehicle, part by part: each is shown to the engine, so that a complaint has its place.

use crate::error::{Checked, Under, Wrong};
use crate::spec::{
    AeroSurfaceSpec, BoardSpec, DifferentialKindSpec, LeanSpec, SlipControlSpec, TyreSpec, VehicleSpec,
    WheelCastSpec, WheelSpec,
};
use jounce::math::Vec3;
use jounce::vehicles::{car, motorcycle, snowboard};
use jounce::{
    AIR_DENSITY, AeroSurfaceDesc, AntiRollDesc, BoardDesc, DifferentialDesc, DifferentialKind, DriveDesc,
    LeanDesc, SlipControlDesc, TrackDesc, TrackSteerDesc, TyreDesc, VehicleDesc, WheelCast, WheelDesc,
};

/// Puts a value where one is given.
fn put<T>(to: &mut T, given: Option<T>) {
    if let Some(v) = given {
        *to = v;
    }
}

/// The engine's complaint at the last word of the field that it names: "track wheels" of a track.
fn placed(e: jounce::Error) -> Wrong {
    let jounce::Error::BadValue { field, value, expected, .. } = &e else { return e.into() };
    let key = field.rsplit([' ', '.']).next().unwrap_or(field);
    Wrong::new(format!("is {value}"), *expected).key(key)
}

/// An angle in degrees, in radians; the bound is a number of degrees that the file can hold to.
fn radians(deg: f32, low: f32, high: f32, key: &str) -> Checked<f32> {
    if (low..=high).contains(&deg) {
        return Ok(deg.to_radians());
    }
    Err(Wrong::new(format!("is {deg}"), format!("{low} to {high} degrees")).key(key))
}

pub(super) fn change(v: &VehicleSpec, d: &mut VehicleDesc) -> Checked<()> {
    axes(v, d)?;
    if let Some(s) = &v.board {
        d.board = Some(board(s, d.board).key("board")?);
        VehicleDesc { board: d.board, wheels: Vec::new(), ..d_alone() }
            .check()
            .map_err(placed)
            .key("board")?;
    }
    wheels(v, d)?;
    drive(v, d)?;
    if let Some(all) = &v.anti_roll {
        d.anti_roll = Vec::new();
        for (i, a) in all.iter().enumerate() {
            d.anti_roll.push(AntiRollDesc { left: a.left, right: a.right, stiffness: a.stiffness });
            d.check().map_err(placed).index(i).key("anti_roll")?;
        }
    }
    if let Some(all) = &v.tracks {
        d.tracks = Vec::new();
        for (i, t) in all.iter().enumerate() {
            d.tracks.push(TrackDesc { wheels: t.wheels.clone() });
            d.check().map_err(placed).index(i).key("tracks")?;
        }
    }
    if let Some(t) = &v.track_steer {
        d.track_steer =
            Some(TrackSteerDesc { left: t.left, right: t.right, speed: t.speed, torque: t.torque });
        d.check().map_err(placed).key("track_steer")?;
    }
    put(&mut d.ackermann, v.ackermann);
    d.check().map_err(placed)?;
    for (spec, to, key) in [(&v.abs, &mut d.abs, "abs"), (&v.traction, &mut d.traction, "traction")] {
        if let Some(s) = spec {
            *to = slip(s, *to);
            VehicleDesc { abs: *to, ..d_alone() }.check().map_err(placed).key(key)?;
        }
    }
    if let Some(all) = &v.aero {
        d.aero = Vec::new();
        for (i, a) in all.iter().enumerate() {
            d.aero.push(surface(a));
            d.check().map_err(placed).index(i).key("aero")?;
        }
    }
    if let Some(s) = &v.lean {
        d.lean = Some(lean(s, d.lean).key("lean")?);
        d.check().map_err(placed).key("lean")?;
    }
    put(&mut d.ground_layers, v.ground_layers.map(|l| l.0));
    put(&mut d.enabled, v.enabled);
    d.check().map_err(placed)
}

/// A vehicle of one sound wheel, to try a part on.
fn d_alone() -> VehicleDesc {
    VehicleDesc::new(jounce::BodyId::from_bits(u64::MAX)).wheel(WheelDesc::new([0.0; 3], 1000.0))
}

fn axes(v: &VehicleSpec, d: &mut VehicleDesc) -> Checked<()> {
    for (given, to, key) in [(v.forward, &mut d.forward, "forward"), (v.up, &mut d.up, "up")] {
        let Some(a) = given else { continue };
        let Some((unit, _)) = Vec3::from_array(a).try_normalize() else {
            return Err(Wrong::new(format!("is {a:?}"), "a direction").key(key));
        };
        *to = unit;
    }
    if d.up.dot(d.forward).abs() > 1e-3 {
        let key = if v.up.is_some() { "up" } else { "forward" };
        return Err(Wrong::new("forward and up are not at right angles", "up across forward").key(key));
    }
    Ok(())
}

fn wheels(v: &VehicleSpec, d: &mut VehicleDesc) -> Checked<()> {
    let of_preset = v.preset.is_some();
    if of_preset && v.wheels.len() > d.wheels.len() {
        let expected = format!("at most {}, those of the preset in turn", d.wheels.len());
        return Err(Wrong::new(format!("has {} entries", v.wheels.len()), expected).key("wheels"));
    }
    if !of_preset {
        for (i, w) in v.wheels.iter().enumerate() {
            let preload = w.preload.or(v.wheel.as_ref().and_then(|w| w.preload));
            let Some(preload) = preload else {
                let expected = "the wheel's share of the weight, N";
                return Err(Wrong::new("the key `preload` is missing", expected).index(i).key("wheels"));
            };
            let Some(position) = w.position else {
                let expected = "the hub in the chassis' frame, m";
                return Err(Wrong::new("the key `position` is missing", expected).index(i).key("wheels"));
            };
            d.wheels.push(WheelDesc::new(position, preload));
        }
        if d.wheels.is_empty() && v.board.is_none() {
            return Err(Wrong::new("nothing is under the vehicle", "wheels, a board or a preset"));
        }
    }
    if let Some(all) = &v.wheel {
        if all.position.is_some() {
            let expected = "a position of each wheel, under `wheels`";
            return Err(Wrong::new("is given for all wheels", expected).key("position").key("wheel"));
        }
        for w in &mut d.wheels {
            wheel(all, w).key("wheel")?;
        }
    }
    for (i, (s, w)) in v.wheels.iter().zip(&mut d.wheels).enumerate() {
        wheel(s, w).index(i).key("wheels")?;
    }
    let Err(e) = VehicleDesc { wheels: d.wheels.clone(), board: d.board, ..d_alone() }.check() else {
        return Ok(());
    };
    // Each of them is sound: it is where they are.
    Err(placed(e).renamed("wheels"))
}

fn wheel(s: &WheelSpec, w: &mut WheelDesc) -> Checked<()> {
    put(&mut w.position, s.position.map(Vec3::from_array));
    put(&mut w.radius, s.radius);
    put(&mut w.width, s.width);
    put(&mut w.mass, s.mass);
    put(&mut w.inertia, s.inertia);
    put(&mut w.bump, s.bump);
    put(&mut w.droop, s.droop);
    put(&mut w.preload, s.preload);
    put(&mut w.stiffness, s.stiffness);
    put(&mut w.bump_damping, s.bump_damping);
    put(&mut w.rebound_damping, s.rebound_damping);
    put(&mut w.bump_stop, s.bump_stop);
    put(&mut w.bump_stop_stiffness, s.bump_stop_stiffness);
    put(&mut w.steer, s.steer_deg.map(|a| radians(a, -85.0, 85.0, "steer_deg")).transpose()?);
    put(&mut w.brake, s.brake);
    put(&mut w.handbrake, s.handbrake);
    put(
        &mut w.cast,
        s.cast.map(|c| match c {
            WheelCastSpec::Cylinder => WheelCast::Cylinder,
            WheelCastSpec::Sphere => WheelCast::Sphere,
            WheelCastSpec::Ray => WheelCast::Ray,
        }),
    );
    let alone = |w: WheelDesc| VehicleDesc { wheels: vec![w], ..d_alone() };
    let before = w.tyre;
    if let Some(t) = &s.tyre {
        tyre(t, &mut w.tyre);
        let tried = WheelDesc { tyre: w.tyre, ..WheelDesc::new([0.0; 3], 1000.0) };
        alone(tried).check().map_err(placed).key("tyre")?;
    }
    alone(WheelDesc { tyre: before, ..*w }).check().map_err(placed)
}

fn tyre(s: &TyreSpec, t: &mut TyreDesc) {
    put(&mut t.static_friction, s.static_friction);
    // As of surfaces: a lower static one takes the kinetic one down, where that is not given.
    if let (Some(mu), None) = (s.static_friction, s.kinetic_friction)
        && mu < t.kinetic_friction
    {
        t.kinetic_friction = mu;
    }
    put(&mut t.kinetic_friction, s.kinetic_friction);
    put(&mut t.slip_stiffness, s.slip_stiffness);
    put(&mut t.cornering_stiffness, s.cornering_stiffness);
    put(&mut t.relaxation_length, s.relaxation_length);
    put(&mut t.radial_stiffness, s.radial_stiffness);
    put(&mut t.radial_damping, s.radial_damping);
    put(&mut t.rolling_resistance, s.rolling_resistance);
    put(&mut t.load_sensitivity, s.load_sensitivity);
    put(&mut t.nominal_load, s.nominal_load);
}

fn kind(s: DifferentialKindSpec) -> DifferentialKind {
    match s {
        DifferentialKindSpec::Open => DifferentialKind::Open,
        DifferentialKindSpec::Locked => DifferentialKind::Locked,
        DifferentialKindSpec::LimitedSlip(l) => {
            DifferentialKind::LimitedSlip { preload: l.preload, lock: l.lock }
        }
    }
}

fn drive(v: &VehicleSpec, d: &mut VehicleDesc) -> Checked<()> {
    let given = [
        ("engine", v.engine.is_some()),
        ("clutch", v.clutch.is_some()),
        ("gearbox", v.gearbox.is_some()),
        ("center", v.center.is_some()),
        ("axles", v.axles.is_some()),
    ];
    let Some((first, _)) = given.iter().find(|(_, g)| *g) else { return Ok(()) };
    let base = d.drive.take().or_else(|| v.axles.is_some().then(|| car().vehicle.drive).flatten());
    let Some(mut drive) = base else {
        let expected = "`axles` beside it: the wheels that are driven";
        return Err(Wrong::new("is given for a vehicle without an engine", expected).key(first));
    };
    if d.wheels.is_empty() {
        return Err(Wrong::new("is given for a vehicle without wheels", "wheels to drive").key(first));
    }
    if let Some(all) = &v.axles {
        drive.axles = all
            .iter()
            .map(|a| DifferentialDesc {
                left: a.left,
                right: a.right,
                kind: a.kind.map_or(DifferentialKind::Open, kind),
                share: a.share.unwrap_or(1.0),
            })
            .collect();
        try_drive(d, &drive).map_err(|e| axle(e, v, &drive, d.wheels.len()))?;
    }
    if let Some(e) = &v.engine {
        put(&mut drive.engine.torque, e.torque.as_ref().map(|t| t.iter().map(|p| (p[0], p[1])).collect()));
        put(&mut drive.engine.inertia, e.inertia);
        put(&mut drive.engine.idle_rpm, e.idle_rpm);
        put(&mut drive.engine.limit_rpm, e.limit_rpm);
        put(&mut drive.engine.drag, e.drag);
        try_drive(d, &drive).map_err(placed).key("engine")?;
    }
    if let Some(c) = &v.clutch {
        put(&mut drive.clutch.torque, c.torque);
        put(&mut drive.clutch.auto_rpm, c.auto_rpm.map(|a| Some((a[0], a[1]))));
        by_hand(&mut drive.clutch.auto_rpm, c.auto_rpm.is_some(), c.manual).key("clutch")?;
        try_drive(d, &drive).map_err(placed).key("clutch")?;
    }
    if let Some(g) = &v.gearbox {
        put(&mut drive.gearbox.forward, g.forward.clone());
        put(&mut drive.gearbox.reverse, g.reverse);
        put(&mut drive.gearbox.final_drive, g.final_drive);
        put(&mut drive.gearbox.shift_s, g.shift_s);
        put(&mut drive.gearbox.auto_rpm, g.auto_rpm.map(|a| Some((a[0], a[1]))));
        by_hand(&mut drive.gearbox.auto_rpm, g.auto_rpm.is_some(), g.manual).key("gearbox")?;
        try_drive(d, &drive).map_err(|e| ratio(e, &drive)).key("gearbox")?;
    }
    put(&mut drive.center, v.center.map(kind));
    try_drive(d, &drive).map_err(placed).key("limited_slip").key("center")?;
    d.drive = Some(drive);
    Ok(())
}

fn try_drive(d: &VehicleDesc, drive: &DriveDesc) -> jounce::Result<()> {
    VehicleDesc { drive: Some(drive.clone()), wheels: d.wheels.clone(), ..d_alone() }.check()
}

fn by_hand(auto: &mut Option<(f32, f32)>, given: bool, manual: Option<bool>) -> Checked<()> {
    if manual == Some(true) {
        if given {
            return Err(
                Wrong::new("is given beside `auto_rpm`", "auto_rpm or manual, not both").key("manual")
            );
        }
        *auto = None;
    }
    Ok(())
}

/// Which ratio is wrong.
fn ratio(e: jounce::Error, drive: &DriveDesc) -> Wrong {
    let jounce::Error::BadValue { field: "ratio", value, expected, .. } = &e else { return placed(e) };
    let wrong = Wrong::new(format!("is {value}"), *expected);
    let bad = |r: &f32| !(1e-3..=1e4).contains(r);
    match drive.gearbox.forward.iter().position(bad) {
        Some(n) => wrong.index(n).key("forward"),
        None if bad(&drive.gearbox.reverse) => wrong.key("reverse"),
        None => wrong.key("final_drive"),
    }
}

/// Which axle is wrong.
fn axle(e: jounce::Error, v: &VehicleSpec, drive: &DriveDesc, wheels: usize) -> Wrong {
    let jounce::Error::BadValue { what, field, value, expected } = &e else {
        return Wrong::from(e).key("axles");
    };
    if *what != "differential" {
        return Wrong::new(format!("is {value}"), *expected).key("axles");
    }
    let sum: f32 = drive.axles.iter().map(|a| a.share).sum();
    let bad = |a: &DifferentialDesc| match *field {
        "left" => a.left >= wheels,
        "right" => a.right >= wheels,
        "share" => !(0.0..=1.0).contains(&a.share),
        _ => matches!(a.kind, DifferentialKind::LimitedSlip { preload, lock }
            if !(0.0..=1e9).contains(&preload) || !(0.0..=100.0).contains(&lock)),
    };
    let wrong = Wrong::new(format!("is {value}"), *expected);
    match drive.axles.iter().position(bad) {
        Some(n) if matches!(*field, "left" | "right" | "share") => wrong.key(field).index(n).key("axles"),
        Some(n) => wrong.key(field).key("limited_slip").key("kind").index(n).key("axles"),
        None => on_two_axles(v, drive)
            .unwrap_or_else(|| Wrong::new(format!("the shares add up to {sum}"), "1 in all").key("axles")),
    }
}

/// A wheel of the vehicle that two axles name.
fn on_two_axles(v: &VehicleSpec, drive: &DriveDesc) -> Option<Wrong> {
    let ends = |a: &DifferentialDesc| [("left", a.left), ("right", a.right)];
    for (j, a) in drive.axles.iter().enumerate() {
        for (key, wheel) in ends(a) {
            let same = |o: &DifferentialDesc| ends(o).iter().any(|e| e.1 == wheel);
            let Some(i) = drive.axles[..j].iter().position(same) else { continue };
            let whose = v.name.as_ref().map_or(String::new(), |name| format!(" of \"{name}\""));
            let message = format!("is {wheel}: wheel {wheel}{whose} is on axle {i} and on axle {j}");
            return Some(Wrong::new(message, "each wheel on one axle").key(key).index(j).key("axles"));
        }
    }
    None
}

fn slip(s: &SlipControlSpec, base: Option<SlipControlDesc>) -> Option<SlipControlDesc> {
    if s.enabled == Some(false) {
        return None;
    }
    let mut d = base.unwrap_or(SlipControlDesc { slip: 0.1, rate: 10.0 });
    put(&mut d.slip, s.slip);
    put(&mut d.rate, s.rate);
    Some(d)
}

fn surface(s: &AeroSurfaceSpec) -> AeroSurfaceDesc {
    AeroSurfaceDesc {
        position: Vec3::from_array(s.position.unwrap_or([0.0; 3])),
        drag_area: s.drag_area.unwrap_or(0.0),
        down_area: s.down_area.unwrap_or(0.0),
        density: s.density.unwrap_or(AIR_DENSITY),
    }
}

fn lean(s: &LeanSpec, base: Option<LeanDesc>) -> Checked<LeanDesc> {
    let base = base.or_else(|| motorcycle().vehicle.lean);
    let mut d = base.unwrap_or(LeanDesc { angle_max: 0.75, hertz: 2.0, damping_ratio: 1.0, wheelbase: 1.4 });
    put(&mut d.angle_max, s.angle_max_deg.map(|a| radians(a, 0.0, 80.0, "angle_max_deg")).transpose()?);
    put(&mut d.hertz, s.hertz);
    put(&mut d.damping_ratio, s.damping_ratio);
    put(&mut d.wheelbase, s.wheelbase);
    Ok(d)
}

fn board(s: &BoardSpec, base: Option<BoardDesc>) -> Checked<BoardDesc> {
    let Some(mut d) = base.or_else(|| snowboard().vehicle.board) else {
        return Err(Wrong::new("there is no board to start from", "all keys of a board"));
    };
    put(&mut d.position, s.position.map(Vec3::from_array));
    put(&mut d.length, s.length);
    put(&mut d.width, s.width);
    put(&mut d.sidecut, s.sidecut);
    put(&mut d.friction, s.friction);
    put(&mut d.edge_friction, s.edge_friction);
    put(&mut d.edge_angle, s.edge_angle_deg.map(|a| radians(a, 0.06, 85.0, "edge_angle_deg")).transpose()?);
    put(&mut d.lean_max, s.lean_max_deg.map(|a| radians(a, 0.0, 80.0, "lean_max_deg")).transpose()?);
    put(&mut d.hertz, s.hertz);
    put(&mut d.damping_ratio, s.damping_ratio);
    put(&mut d.stiffness, s.stiffness);
    put(&mut d.damping, s.damping);
    put(&mut d.reach, s.reach);
    put(&mut d.jump_speed, s.jump_speed);
    Ok(d)
}

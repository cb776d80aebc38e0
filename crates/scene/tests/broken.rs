//! Hand-broken scene files: each is refused at the right line and key, in the right words.

use jounce_scene::{LoadOptions, Scene, SceneError};
use std::path::{Path, PathBuf};

/// File, line, key path, and a part of the message.
const BROKEN: &[(&str, usize, &str, &str)] = &[
    ("unknown_key", 9, "bodies[1].positoin", "unknown key; expected one of name, type, position"),
    ("unknown_top_key", 4, "body", "(did you mean `bodies`?)"),
    ("unknown_shape", 11, "bodies[1].shapes[1].shpere", "(did you mean `sphere`?)"),
    ("trailing_comma", 11, "bodies[1].shapes[1]", "no comma before a closing bracket"),
    ("missing_comma", 10, "bodies[1]", "expected `,` or `}`"),
    ("comment", 9, "bodies[1]", "comments are not part of JSON"),
    ("truncated", 6, "bodies[0]", "the file ends here"),
    ("nan", 10, "bodies[1].position[1]", "found `NaN`; expected a finite number"),
    ("infinite", 10, "bodies[1].position[2]", "1e999 is out of range"),
    ("duplicate_key", 11, "bodies[1].position", "the key is given twice"),
    ("wrong_type_string", 9, "bodies[1].velocity", "string \"fast\"; expected an array of length 3"),
    ("wrong_type_number", 10, "bodies[1].shapes[0].box.half", "expected an array of length 3"),
    ("short_array", 11, "bodies[1].shapes[0].box.half", "expected an array of length 3"),
    ("missing_key", 10, "bodies[1].shapes[0].sphere", "the key `radius` is missing"),
    ("missing_version", 1, "(top level)", "the key `jounce` is missing; expected \"jounce\": 1, the version"),
    ("wrong_version", 3, "jounce", "version 2; expected 1"),
    ("unknown_type", 5, "bodies[0].type", "(did you mean `dynamic`?)"),
    ("negative_radius", 12, "bodies[1].shapes[1].sphere.radius", "is -1"),
    ("two_kinds", 10, "bodies[1].shapes[0]", "the shape has 2 kinds: sphere, box"),
    ("no_kind", 10, "bodies[1].shapes[0]", "the shape has no kind"),
    ("unknown_material", 12, "bodies[1].shapes[0].material", "(did you mean `ice`?)"),
    ("bad_material", 7, "materials.rubber.restitution", "is 1.5; expected 0 to 1"),
    ("kinetic_above_static", 7, "materials.odd.kinetic_friction", "not above static_friction"),
    ("bad_settings", 6, "settings.contact_hertz", "is -30"),
    ("bad_substeps", 6, "step.substeps", "is 0; expected 1 to 64"),
    ("fractional_substeps", 6, "step.substeps", "expected a whole number"),
    ("missing_mesh_file", 6, "meshes.rock.file", "there is no such file"),
    ("preset_with_direction", 6, "emitters[0].direction", "is given beside `preset`"),
    ("unknown_mesh", 6, "bodies[0].shapes[0].mesh.mesh", "there is no mesh \"level\""),
    (
        "dynamic_half_space",
        10,
        "bodies[1].shapes[0]",
        "half-space on a dynamic body: put it on a fixed or kinematic body",
    ),
    ("huge_repeat", 11, "bodies[1].repeat.count", "at most 524288 bodies"),
    ("same_name_twice", 7, "bodies[2].name", "\"a\" is given to two bodies"),
    ("unknown_probe_body", 5, "probes.height.body", "(did you mean `ball`?)"),
    ("unknown_probe_value", 6, "probes.height.value", "(did you mean `position.y`?)"),
    ("copies_without_aggregate", 5, "probes.height.body", "names 3 bodies"),
    ("expect_without_probe", 5, "expect[0].probe", "there is no probe \"height\""),
    ("trail_of_nobody", 6, "render.trails.bodies[1]", "(did you mean `ball`?)"),
    ("trail_without_time", 7, "render.trails.seconds", "is 0; expected more than 0"),
    ("push_nobody", 6, "timeline[1].push.body", "there is no body \"box\""),
    ("two_actions", 5, "timeline[0]", "the entry has 2 actions"),
    ("bad_color", 10, "bodies[1].color", "is \"reddish\"; expected a colour"),
    ("both_rotations", 10, "bodies[1].rotation", "rotation or rotation_deg, not both"),
    ("wrong_height_count", 7, "bodies[0].shapes[0].height_field.heights", "columns × rows = 6"),
    ("flat_hull", 10, "bodies[1].shapes[0].hull", "coplanar"),
    ("mesh_bad_line", 6, "meshes.rock.file", "bad_line.obj:3:7: found `nan`; expected a finite number"),
    ("mesh_short_stl", 6, "meshes.rock.file", "short.stl: byte 12: the file ends after 12 bytes"),
    (
        "expect_after_the_end",
        10,
        "expect[1].at",
        "is 2.5, beyond the end of the run; expected at most `seconds`, 2",
    ),
    (
        "action_after_the_end",
        8,
        "timeline[1].at",
        "is 2, beyond the end of the run; expected no later than the last step of `seconds`, 2, which starts at 1.9833",
    ),
    (
        "move_a_dynamic_body",
        7,
        "timeline[0].move_to.body",
        "\"ball\" names a dynamic body; expected kinematic bodies",
    ),
    ("set_velocity_of_ground", 7, "timeline[0].set_velocity.body", "\"ground\" names a fixed body"),
    ("push_the_ground", 7, "timeline[0].push.body", "\"ground\" names a fixed body; expected dynamic bodies"),
    (
        "push_a_lift",
        12,
        "timeline[0].push.body",
        "\"all[1]\" names a kinematic body; expected dynamic bodies",
    ),
    (
        "no_mass",
        6,
        "bodies[1]",
        "the dynamic body has no mass; expected a shape that is no sensor, with density",
    ),
    ("zero_fov", 5, "camera.fov_deg", "is 0; expected 1 to 170 degrees"),
    (
        "joint_without_kind",
        6,
        "joints[0]",
        "the joint has no kind; expected exactly one of fixed, ball, hinge",
    ),
    ("joint_two_kinds", 6, "joints[0]", "the joint has 2 kinds: fixed, ball"),
    (
        "joint_unknown_body",
        7,
        "joints[0].b",
        "there is no body \"arms\"; expected the name of a body: arm, post (did you mean `arm`?)",
    ),
    ("joint_of_many", 7, "joints[0].b", "names 3 of them; expected one, such as arm[0]"),
    ("joint_to_itself", 7, "joints[0].b", "\"arm\" number 1 is both ends; expected another body than a"),
    ("joint_without_place", 6, "joints[0]", "the joint has no place; expected at, or at_a and at_b"),
    (
        "joint_rod_at",
        7,
        "joints[0].at",
        "is given for a distance joint, which has two points; expected at_a and at_b",
    ),
    ("joint_one_anchor", 7, "joints[0].at_a", "is given without `at_b`; expected both points"),
    ("joint_zero_axis", 7, "joints[0].axis", "expected a direction"),
    (
        "joint_degrees_of_a_slider",
        8,
        "joints[0].slider.limit.max_deg",
        "an axis that does not turn; expected max in metres",
    ),
    ("joint_limit_reversed", 8, "joints[0].hinge.limit.min_deg", "is 30; expected not above the other end"),
    ("joint_motor_without_spring", 8, "joints[0].hinge.motor.position_deg", "is given without `spring`"),
    (
        "joint_spring_two_ways",
        7,
        "joints[0].spring",
        "given in two ways; expected hertz with damping_ratio, or stiffness",
    ),
    ("joint_soft_spring", 7, "joints[0].spring.hertz", "is 0.0; expected above 0"),
    ("joint_copies_too_far", 7, "joints[0].b", "the copies reach arm[3]; expected arm[0] to arm[2]"),
    ("joint_gear_of_a_ball", 9, "joints[2].gear.a", "\"a\" is a ball joint; expected a hinge or a slider"),
    ("joint_same_name_twice", 7, "joints[1].name", "\"a\" is given to two joints"),
    ("joint_misspelt", 7, "joints[0].hinge.moter", "(did you mean `motor`?)"),
    ("joint_breaks_at_nothing", 7, "joints[0].break_force", "is 0.0; expected above 0 N"),
    ("joint_one_point_path", 7, "joints[0].path.points", "is 1; expected 2 to 4096 points"),
    (
        "cut_nothing",
        9,
        "timeline[0].cut.joint",
        "there is no joint \"pins\"; expected the name of a joint: pin (did you mean `pin`?)",
    ),
    ("motor_of_a_rope", 9, "timeline[0].set_motor.joint", "is a distance joint, which has no motor"),
    (
        "set_another_kind",
        9,
        "timeline[0].set_joint.hinge",
        "is given for a distance joint; expected `distance`",
    ),
    ("unknown_joint_value", 9, "probes.pull.value", "(did you mean `force`?)"),
    ("full_scatter", 7, "scatter[0].min_distance", "the box has room for"),
    ("field_unknown_law", 9, "fields[1].gravity_well", "unknown key; expected one of"),
    ("field_two_laws", 8, "fields[1]", "the field has 2 laws: wind, drag; expected exactly one of"),
    ("field_no_law", 8, "fields[1]", "the field has no law; expected exactly one of uniform"),
    ("field_negative_density", 9, "fields[1].drag.density", "is -1.0; expected 0 to"),
    ("field_huge_number", 9, "fields[1].uniform.acceleration", "expected finite, at most"),
    ("field_number_beyond_f32", 9, "fields[1].uniform.acceleration[1]", "1e39"),
    ("field_nan", 9, "fields[1].point.mu", "found `NaN`; expected"),
    ("field_huge_mu", 9, "fields[1].point.mu", "expected finite, at most 1e30"),
    ("field_huge_mass", 9, "fields[1].point.mass", "1e300 is out of range"),
    ("field_mu_and_mass", 9, "fields[1].point.mu", "mu or mass, not both"),
    ("field_nothing_attracts", 8, "fields[1].point", "nothing attracts; expected mu or mass"),
    ("field_negative_softening", 9, "fields[1].point.softening", "is -1"),
    ("field_of_nobody", 9, "fields[1].n_body.bodies[1]", "(did you mean `ball`?)"),
    ("field_gust_without_size", 9, "fields[1].wind.gust.size", "is 0"),
    ("field_level_and_surface", 9, "fields[1].water.level", "level or surface, not both"),
    ("field_zero_normal", 9, "fields[1].water.normal", "is zero; expected a direction"),
    ("field_vortex_without_core", 9, "fields[1].vortex.core_radius", "is 0"),
    ("field_turning_too_fast", 9, "fields[1].rotating_frame.angular_velocity", "at most 1000 rad/s"),
    ("field_region_without_size", 9, "fields[1].region.sphere.radius", "is 0.0; expected above 0"),
    ("field_region_turned_inside_out", 9, "fields[1].region.box.half", "expected above 0"),
    ("field_region_of_two_shapes", 9, "fields[1].region", "exactly one of sphere, box"),
    ("field_negative_rim", 9, "fields[1].region.falloff", "is -1"),
    ("field_name_twice", 8, "fields[1].name", "\"gravity\" is given to two fields"),
    ("aero_negative_drag", 6, "bodies[0].shapes[0].aero.drag", "is -0.5; expected 0 to"),
    ("aero_huge_area", 6, "bodies[0].shapes[0].aero.area", "expected 0 to"),
    ("aero_unknown_key", 6, "bodies[0].shapes[0].aero.lfit", "(did you mean `lift`?)"),
    ("aero_huge_lift", 6, "bodies[0].shapes[0].aero.lift", "expected -100 to 100"),
    ("system_of_two_kinds", 8, "systems[1]", "exactly one of points, cloth, jelly"),
    ("system_of_no_kind", 8, "systems[1]", "exactly one of points, cloth, jelly"),
    ("system_name_twice", 8, "systems[1].name", "\"net\" is given to two systems"),
    ("system_negative_mass", 9, "systems[1].points[1].mass", "is -1"),
    ("system_point_far_away", 9, "systems[1].points[1].position[0]", "1e300 is out of range"),
    ("system_speed_beyond_all", 9, "systems[1].points[1].velocity[1]", "1e300 is out of range"),
    (
        "spring_between_absent_points",
        10,
        "systems[1].springs[1].ends[1]",
        "there is no point 2; expected a number below 2",
    ),
    ("spring_to_itself", 10, "systems[1].springs[0].ends", "two different points"),
    ("spring_without_stiffness", 10, "systems[1].springs[0].stiffness", "is -10"),
    ("spring_negative_damping", 10, "systems[1].springs[0].damping", "is -1"),
    ("spring_of_negative_length", 10, "systems[1].springs[0].length", "is -1"),
    ("springs_without_points", 9, "systems[1].springs", "springs only beside points"),
    ("system_unknown_method", 9, "systems[1].method", "expected"),
    ("system_without_step", 9, "systems[1].step_s", "is 0; expected 1e-6 to 100 s"),
    ("system_without_radius", 9, "systems[1].radius", "is 0; expected 1e-6 to"),
    ("system_bounces_too_high", 9, "systems[1].collide.restitution", "is 1.5; expected 0 to 1"),
    ("system_negative_trail", 9, "systems[1].trail_s", "is -1"),
    ("system_too_many_points", 8, "systems[1]", "expected at most 65536 points in all systems"),
    ("cloth_of_one_row", 9, "systems[1].cloth.rows", "is 1"),
    ("cloth_without_mass", 9, "systems[1].cloth.mass", "is 0"),
    ("cloth_without_width", 9, "systems[1].cloth.across", ""),
    ("cloth_of_negative_springs", 9, "systems[1].cloth.shear.stiffness", "is -1"),
    ("jelly_without_size", 9, "systems[1].jelly.size[1]", "is 0.0; expected a finite number above 0"),
    ("jelly_of_no_particles", 9, "systems[1].jelly.particles", "expected"),
    ("emitter_rate_of_a_flood", 9, "emitters[1].rate", "expected 0 to 1e7 particles a second"),
    ("emitter_on_nobody", 9, "emitters[1].body", "(did you mean `ball`?)"),
    ("emitter_on_many", 9, "emitters[1].body", "names 3 bodies; expected one, such as heap[0]"),
    ("emitter_on_no_mesh", 9, "emitters[1].shape.mesh", "there is no mesh \"rock\""),
    ("emitter_spread_beyond_180", 9, "emitters[1].spread_deg", "is 190; expected 0 to 180 degrees"),
    (
        "emitter_nozzle_beyond_90",
        9,
        "emitters[1].shape.cone.half_angle_deg",
        "is 181; expected 0 to 90 degrees",
    ),
    ("emitter_negative_mass", 9, "emitters[1].mass", "is -0.1"),
    ("emitter_without_radius", 9, "emitters[1].radius", "smallest first"),
    ("emitter_lives_backwards", 9, "emitters[1].lifetime_s", "shortest first"),
    ("emitter_speed_beyond_all", 9, "emitters[1].speed", "expected 0 to 10000 m/s, lowest first"),
    ("emitter_of_too_many", 9, "emitters[1].max_particles", "expected 1 to 4194304"),
    ("emitter_of_none", 9, "emitters[1].max_particles", "is 0; expected 1 to"),
    ("emitter_burst_of_half", 9, "emitters[1].bursts[1].count", "expected"),
    ("emitter_burst_before_all", 9, "emitters[1].bursts[1].time_s", "is -1"),
    ("emitter_of_many_bursts", 9, "emitters[1].bursts", "at most 16"),
    ("emitter_preset_with_rate", 9, "emitters[1].rate", "is given beside `preset`"),
    ("emitter_unknown_preset", 9, "emitters[1].preset", "(did you mean `fire`?)"),
    ("emitter_scale_without_preset", 9, "emitters[1].scale", "scale only beside preset"),
    ("emitter_preset_too_large", 9, "emitters[1].scale", "expected 0.01 to 10000 m"),
    ("emitter_of_two_shapes", 9, "emitters[1].shape", "exactly one of sphere"),
    ("emitter_negative_sphere", 9, "emitters[1].shape.sphere", "is -1"),
    ("emitter_negative_surface", 9, "emitters[1].shape.sphere_surface", "is -1"),
    ("emitter_negative_disc", 9, "emitters[1].shape.disc", "is -2"),
    ("emitter_negative_box", 9, "emitters[1].shape.box", "is -1"),
    ("emitter_negative_nozzle", 9, "emitters[1].shape.cone.radius", "is -1"),
    ("emitter_zero_direction", 9, "emitters[1].direction", "is zero; expected a direction"),
    ("emitter_turbulence_without_size", 9, "emitters[1].turbulence.size", "is 0"),
    ("emitter_turbulence_without_drag", 9, "emitters[1].turbulence", "drag"),
    ("emitter_heat_without_cooling", 9, "emitters[1].heat.cooling_s", "is 0"),
    ("emitter_bounces_too_high", 9, "emitters[1].collision.restitution", "is 2.0; expected 0 to 1"),
    ("emitter_unknown_response", 9, "emitters[1].collision.response", "(did you mean `bounce`?)"),
    ("emitter_loops_without_end", 9, "emitters[1].looping", "expected a duration_s to begin again after"),
    ("emitter_colors_out_of_order", 9, "emitters[1].color_over_life", "in order"),
    ("emitter_name_twice", 8, "emitters[1].name", "\"fire\" is given to two emitters"),
    ("explode_without_reach", 10, "timeline[1].explode.radius", "is 0"),
    ("explode_beyond_all", 10, "timeline[1].explode.impulse", "at most 1e12"),
    ("explode_far_away", 10, "timeline[1].explode.center[1]", "1e300 is out of range"),
    ("explode_out_of_the_world", 10, "timeline[1].explode.center", "within 1e9 m"),
    ("set_field_of_nobody", 10, "timeline[1].set_field.field", "(did you mean `breeze`?)"),
    ("set_field_without_a_state", 10, "timeline[1].set_field", "the key `enabled` is missing"),
    ("emit_of_nobody", 10, "timeline[1].emit.emitter", "(did you mean `sparks`?)"),
    ("emit_less_than_none", 10, "timeline[1].emit.count", "expected"),
    ("emit_beyond_all", 10, "timeline[1].emit.count", "expected"),
    ("set_emitter_of_nobody", 10, "timeline[1].set_emitter.emitter", "there is no emitter \"ball\""),
    ("probe_of_no_system", 9, "probes.p.system", "(did you mean `rope`?)"),
    ("probe_of_no_point", 9, "probes.p.point", "2"),
    ("probe_point_without_system", 9, "probes.p.point", "point only beside system"),
    ("probe_unknown_system_value", 9, "probes.p.value", "expected"),
    ("probe_of_no_emitter", 9, "probes.p.emitter", "(did you mean `sparks`?)"),
    ("probe_unknown_emitter_value", 9, "probes.p.value", "(did you mean `born`?)"),
    ("probe_of_emitter_and_system", 9, "probes.p.emitter", "value only"),
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/broken")
}

#[test]
fn each_broken_file_is_refused_at_its_line() {
    let mut wrong = Vec::new();
    for (name, line, key, part) in BROKEN {
        let e = match Scene::load(folder().join(format!("{name}.json")), &LoadOptions::default()) {
            Ok(_) => {
                wrong.push(format!("{name}: accepted"));
                continue;
            }
            Err(e) => e,
        };
        let told = e.to_string();
        let right = e.fault().is_some_and(|f| {
            f.position.is_some_and(|p| p.line == *line) && f.key == *key && told.contains(part)
        });
        if !right || told.contains('\n') {
            wrong.push(format!("{name}: wanted {line}: {key}: …{part}…\n    got {told}"));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn the_table_names_every_file() {
    let entries = std::fs::read_dir(folder()).expect("the folder is there");
    let mut files: Vec<String> =
        entries.filter_map(|e| Some(e.ok()?.path().file_stem()?.to_str()?.to_string())).collect();
    files.sort();
    let mut table: Vec<&str> = BROKEN.iter().map(|b| b.0).collect();
    table.sort_unstable();
    assert_eq!(files, table);
    assert!(table.len() >= 30);
}

#[test]
fn absent_assets_skip_the_scene() {
    let text = r#"{"jounce": 1, "meshes": {"a": {"file": "assets:box3d/stairs.obj"}}}"#;
    let options = LoadOptions { assets: "no/such/folder".into() };
    let e = Scene::from_str(text, "a.json", &options).expect_err("skipped");
    assert!(matches!(&e, SceneError::Skipped(why) if why.contains("no/such/folder")), "{e}");
    // With the folder there, a file that is not there is a mistake.
    let options = LoadOptions { assets: folder() };
    let e = Scene::from_str(text, "a.json", &options).expect_err("refused");
    assert_eq!(e.fault().map(|f| f.key.as_str()), Some("meshes.a.file"), "{e}");
}

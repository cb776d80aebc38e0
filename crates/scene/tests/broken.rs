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

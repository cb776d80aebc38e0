//! Every bound of this crate. Reaching one is an error that names it.

/// Largest scene file, bytes.
pub const SCENE_BYTES_MAX: usize = 64 << 20;
/// Largest mesh file (and largest buffer beside a glTF), bytes.
pub const MESH_BYTES_MAX: u64 = 256 << 20;
/// Deepest nesting of arrays and objects.
pub const JSON_DEPTH_MAX: usize = 64;
/// Most objects in one scene file (bounds memory: an object of three bytes may become a few hundred).
pub const JSON_OBJECTS_MAX: usize = 1 << 17;
/// Most values of any kind in one scene file.
pub const JSON_VALUES_MAX: usize = 1 << 24;
/// Longest string in a scene file, bytes.
pub const JSON_STRING_MAX: usize = 4096;
/// Most points of all point-spring systems of one scene.
pub const SYSTEM_POINTS_MAX: u64 = 1 << 16;
/// Most bodies of one scene, copies and timed spawns included.
pub const SCENE_BODIES_MAX: u64 = 1 << 19;
/// Most shapes of one scene, copies and timed spawns included.
pub const SCENE_SHAPES_MAX: u64 = 1 << 20;
/// Most joints of one scene, copies and timed spawns included.
pub const SCENE_JOINTS_MAX: u64 = 1 << 19;
/// Most entries a timeline may expand to.
pub const TIMELINE_MAX: u64 = 1 << 19;
/// Longest run, seconds of simulated time.
pub const SECONDS_MAX: f64 = 1e7;
/// Most corners of one polygon of a mesh file.
pub const POLYGON_CORNERS_MAX: usize = 1024;
/// Longest line of a text mesh, bytes.
pub const MESH_LINE_MAX: usize = 1 << 16;
/// Most material groups of one mesh.
pub const MESH_GROUPS_MAX: usize = 1 << 12;
/// A mesh may expand to this many bytes plus eight times its file (instances share data in glTF).
pub const MESH_EXPANSION_BYTES: usize = 32 << 20;
/// Most nodes of one glTF file.
pub const GLTF_NODES_MAX: usize = 1 << 16;
/// Most bodies of all scatter groups of one scene (each is drawn and kept while the scene is read).
pub const SCATTER_BODIES_MAX: u64 = 1 << 17;
/// Draws for one place of a scatter group before the box counts as full.
pub const SCATTER_TRIES_MAX: u64 = 256;
/// Draws of a whole scatter group for each of its bodies, on average.
pub const SCATTER_TRIES_EACH: u64 = 32;
/// Most samples of all height functions of one scene.
pub const HEIGHT_SAMPLES_MAX: usize = 1 << 22;
/// Most bodies with trails.
pub const TRAILS_MAX: u64 = 1024;
/// Widest trail, m.
pub const TRAIL_WIDTH_MAX: f32 = 1000.0;
/// Most rows that probes and step times keep; beyond it every second row is dropped and the stride doubles.
pub const ROWS_MAX: usize = 1 << 18;
/// Triangles that the meshes of a scene may have whatever their files' size. Beyond, [`MESH_BYTES_EACH`].
pub const MESH_TRIANGLES_FREE: usize = 1 << 18;
/// Bytes of mesh files for each further triangle. A triangle of a collision mesh takes up to 200 bytes, and the files' own
/// bytes may take sixteen times themselves: polygons of "1 2 3 1 2 3 …" spend two bytes on a triangle.
pub const MESH_BYTES_EACH: usize = 13;
/// Most cells, summed over its triangles, that a mesh to be cut may cross (memory: about 160 bytes each).
pub const CUT_CELLS_MAX: f64 = 262_144.0;
/// Most different decompositions of one scene.
pub const CUTS_MAX: usize = 8;
/// Most bytes of all mesh files of one scene.
pub const MESH_TOTAL_BYTES: u64 = 1 << 30;
/// Most angular velocity of a bone of a pose about each axis, rad/s; in the joint's axes it stays below the engine's bound.
pub const SPIN_POSED_MAX: f32 = 1e4;

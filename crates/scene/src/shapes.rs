//! Shapes of a scene file into shapes of the engine.

use crate::decompose::decompose;
use crate::error::{Checked, SceneError, Under, Wrong, closest};
use crate::mesh::MeshData;
use crate::random::noise;
use crate::spec::{CombineSpec, SettingsSpec};
use crate::spec::{
    DecomposeSpec, HeightFieldSpec, HeightFunctionSpec, HullSpec, Map, MaterialSpec, MeshFileSpec, MeshSpec,
    ShapeSpec, UpSpec,
};
use jounce::geometry::{Compound, HeightField, Hull, Shape, TriMesh, TriMeshOptions, limits as bounds};
use jounce::math::scalar::f64s;
use jounce::math::{DQuat, DVec3, Pose, Quat, Vec3};
use jounce::{Combine, Filter, MassSpec, Material, Settings, ShapeDesc};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A mesh file with its scale and axes applied, and what was built from it so far.
struct Loaded {
    data: MeshData,
    options: TriMeshOptions,
    mesh: Option<Arc<TriMesh>>,
    hull: Option<Arc<Hull>>,
}

/// The named things that shapes refer to.
pub(crate) struct Library {
    materials: BTreeMap<String, Material>,
    meshes: BTreeMap<String, Loaded>,
    /// Samples that height functions may still make.
    samples: usize,
    /// Meshes cut so far.
    parts: Vec<(DecomposeSpec, Arc<Compound>)>,
}

fn article(what: &str) -> &'static str {
    if what.starts_with(['a', 'e', 'i', 'o']) { "an" } else { "a" }
}

/// An unknown name, with a guess.
pub(crate) fn unknown<'a>(what: &str, name: &str, known: impl Iterator<Item = &'a str> + Clone) -> Wrong {
    let mut list: Vec<&str> = known.clone().take(9).collect();
    if list.len() == 9 {
        list[8] = "…";
    }
    let expected = if list.is_empty() {
        format!("the name of {} {what}; the scene has none", article(what))
    } else {
        format!("the name of {} {what}: {}", article(what), list.join(", "))
    };
    Wrong::new(format!("there is no {what} \"{name}\""), expected).suggest(closest(name, known))
}

impl Library {
    /// Checks the materials and loads the meshes; `read` reads one mesh by its `file` entry.
    pub(crate) fn new(
        materials: &Map<MaterialSpec>,
        meshes: &Map<MeshFileSpec>,
        mut read: impl FnMut(&str) -> Result<MeshData, SceneError>,
    ) -> Checked<Self> {
        let samples = crate::limits::HEIGHT_SAMPLES_MAX;
        let mut library =
            Self { materials: BTreeMap::new(), meshes: BTreeMap::new(), samples, parts: Vec::new() };
        for (name, m) in &materials.0 {
            let built = material(m).key(name).key("materials")?;
            library.materials.insert(name.clone(), built);
        }
        for (name, m) in &meshes.0 {
            let loaded = place(m, &mut read).key(name).key("meshes")?;
            library.meshes.insert(name.clone(), loaded);
        }
        Ok(library)
    }

    fn material(&self, name: &str) -> Checked<Material> {
        let known = self.materials.keys().map(String::as_str);
        self.materials.get(name).copied().ok_or_else(|| unknown("material", name, known))
    }

    fn loaded(&mut self, name: &str) -> Checked<&mut Loaded> {
        if !self.meshes.contains_key(name) {
            return Err(unknown("mesh", name, self.meshes.keys().map(String::as_str)));
        }
        self.meshes.get_mut(name).ok_or_else(|| Wrong::new("no mesh", ""))
    }

    /// A shape with its surface, place and filter.
    pub(crate) fn shape(&mut self, s: &ShapeSpec) -> Checked<ShapeDesc> {
        let mut d = ShapeDesc::new(self.geometry(s)?);
        d.pose = pose(s)?;
        d.mass = match (s.density, s.mass) {
            (Some(_), Some(_)) => {
                return Err(Wrong::new("given beside `mass`", "density or mass, not both").key("density"));
            }
            (Some(x), None) => MassSpec::Density(x),
            (None, Some(x)) => MassSpec::Mass(x),
            (None, None) => d.mass,
        };
        if let Some(name) = &s.material {
            d.material = self.material(name).key("material")?;
        }
        if let Some(m) = &s.mesh {
            d.triangle_materials = self.triangle_materials(m, d.material).key("mesh")?;
        }
        let filter = Filter::default();
        d.filter = Filter {
            layers: s.layer.map_or(filter.layers, |l| l.0),
            mask: s.mask.map_or(filter.mask, |l| l.0),
            group: s.group.unwrap_or(filter.group),
        };
        if let Some(a) = &s.aero {
            d.aero = crate::fields::aero(a).key("aero")?;
        }
        d.sensor = s.sensor.unwrap_or(d.sensor);
        d.enabled = s.enabled.unwrap_or(d.enabled);
        d.contact_events = s.contact_events.unwrap_or(d.contact_events);
        d.hit_events = s.hit_events.unwrap_or(d.hit_events);
        d.check()?;
        Ok(d)
    }

    fn geometry(&mut self, s: &ShapeSpec) -> Checked<Shape> {
        let given = kinds(s);
        let names: Vec<&str> = given.iter().filter(|(_, there)| *there).map(|(n, _)| *n).collect();
        if names.len() != 1 {
            let all: Vec<&str> = given.iter().map(|(n, _)| *n).collect();
            let message = match names.len() {
                0 => "the shape has no kind".to_string(),
                _ => format!("the shape has {} kinds: {}", names.len(), names.join(", ")),
            };
            return Err(Wrong::new(message, format!("exactly one of {}", all.join(", "))));
        }
        let shape = self.one_kind(s)?;
        shape.check()?;
        Ok(shape)
    }

    fn one_kind(&mut self, s: &ShapeSpec) -> Checked<Shape> {
        if let Some(x) = s.sphere {
            return Ok(Shape::Sphere { radius: x.radius });
        }
        if let Some(x) = s.capsule {
            return Ok(Shape::Capsule { half_height: x.half_height, radius: x.radius });
        }
        if let Some(x) = s.cuboid {
            return Ok(Shape::Box { half: Vec3::from_array(x.half) });
        }
        if let Some(x) = s.cylinder {
            return Ok(Shape::Cylinder { half_height: x.half_height, radius: x.radius });
        }
        if let Some(x) = s.cone {
            return Ok(Shape::Cone { half_height: x.half_height, radius: x.radius });
        }
        if let Some(x) = s.half_space {
            let n = Vec3::from_array(x.normal);
            let length = n.length();
            if !(length > 1e-6 && length <= 1e6) {
                return Err(Wrong::new(format!("has length {length}"), "a direction")
                    .key("normal")
                    .key("half_space"));
            }
            return Ok(Shape::HalfSpace { normal: n / length, offset: x.offset.unwrap_or(0.0) });
        }
        if let Some(x) = &s.hull {
            return self.hull(x).map(Shape::Hull);
        }
        if let Some(x) = &s.mesh {
            return self.mesh(x).map(Shape::Mesh);
        }
        if let Some(x) = &s.height_field {
            return height_field(x, &mut self.samples).map(|f| Shape::HeightField(Arc::new(f)));
        }
        if let Some(x) = &s.compound {
            let mut children = Vec::with_capacity(x.children.len());
            for (i, child) in x.children.iter().enumerate() {
                children.push(self.child(child).index(i).key("children").key("compound")?);
            }
            return Ok(Shape::Compound(Arc::new(Compound::new(children)?)));
        }
        if let Some(x) = &s.decompose {
            return self.parts(x).map(Shape::Compound).key("decompose");
        }
        Err(Wrong::new("the shape has no kind", "a kind"))
    }

    fn parts(&mut self, d: &DecomposeSpec) -> Checked<Arc<Compound>> {
        if let Some((_, parts)) = self.parts.iter().find(|(known, _)| known == d) {
            return Ok(parts.clone());
        }
        if self.parts.len() >= crate::limits::CUTS_MAX {
            return Err(Wrong::new(
                "too many different decompositions",
                format!("at most {} in a scene", crate::limits::CUTS_MAX),
            ));
        }
        let parts = Arc::new(decompose(d, &self.loaded(&d.mesh).key("mesh")?.data)?);
        self.parts.push((d.clone(), parts.clone()));
        Ok(parts)
    }

    fn child(&mut self, s: &ShapeSpec) -> Checked<(Pose, Shape)> {
        let bare = ShapeSpec { position: None, rotation: None, rotation_deg: None, ..s.clone() };
        let others = [
            ("density", bare.density.is_some()),
            ("mass", bare.mass.is_some()),
            ("material", bare.material.is_some()),
            ("sensor", bare.sensor.is_some()),
            ("layer", bare.layer.is_some()),
            ("mask", bare.mask.is_some()),
            ("group", bare.group.is_some()),
            ("enabled", bare.enabled.is_some()),
            ("contact_events", bare.contact_events.is_some()),
            ("hit_events", bare.hit_events.is_some()),
        ];
        if let Some((key, _)) = others.iter().find(|(_, there)| *there) {
            let expected = "only position and rotation on a child; the compound carries the rest";
            return Err(Wrong::new("is given on a child", expected).key(key).of_key());
        }
        let shape = self.geometry(&bare)?;
        if !shape.is_convex() {
            return Err(Wrong::new(format!("a {} is not convex", shape.name()), "convex children"));
        }
        Ok((pose(s)?, shape))
    }

    fn hull(&mut self, h: &HullSpec) -> Checked<Arc<Hull>> {
        match (&h.points, &h.mesh) {
            (Some(points), None) => {
                let points: Vec<Vec3> = points.iter().map(|p| Vec3::from_array(*p)).collect();
                Ok(Arc::new(Hull::new(&points)?))
            }
            (None, Some(name)) => {
                let loaded = self.loaded(name).key("mesh").key("hull")?;
                if let Some(hull) = &loaded.hull {
                    return Ok(hull.clone());
                }
                let hull = Arc::new(Hull::new(&used_vertices(&loaded.data))?);
                loaded.hull = Some(hull.clone());
                Ok(hull)
            }
            _ => Err(Wrong::new("needs points or a mesh", "exactly one of points, mesh").key("hull")),
        }
    }

    /// A named mesh.
    /// A mesh from a file, by its name, which stands at the key `mesh`.
    pub(crate) fn tri_mesh(&mut self, name: &str) -> Checked<Arc<TriMesh>> {
        let loaded = self.loaded(name).key("mesh")?;
        if let Some(mesh) = &loaded.mesh {
            return Ok(mesh.clone());
        }
        let data = &loaded.data;
        let mut mesh = TriMesh::new(&data.vertices, &data.triangles, loaded.options)?;
        if data.groups.len() > 1 {
            mesh = mesh.with_materials(&data.triangle_groups)?;
        }
        let mesh = Arc::new(mesh);
        loaded.mesh = Some(mesh.clone());
        Ok(mesh)
    }

    fn mesh(&mut self, m: &MeshSpec) -> Checked<Arc<TriMesh>> {
        match (&m.mesh, &m.vertices, &m.triangles) {
            (Some(name), None, None) => self.tri_mesh(name).key("mesh"),
            (None, Some(v), Some(t)) => {
                let vertices: Vec<Vec3> = v.iter().map(|p| Vec3::from_array(*p)).collect();
                let double_sided = m.double_sided.unwrap_or(false);
                let options = TriMeshOptions { double_sided, ..TriMeshOptions::default() };
                Ok(Arc::new(TriMesh::new(&vertices, t, options)?))
            }
            _ => {
                let expected = "either mesh (a name) or vertices and triangles";
                Err(Wrong::new("needs a mesh", expected).key("mesh"))
            }
        }
    }

    fn triangle_materials(&mut self, m: &MeshSpec, rest: Material) -> Checked<Vec<Material>> {
        let spec = &m.triangle_materials;
        let (Some(name), false) = (&m.mesh, spec.0.is_empty()) else {
            return match spec.0.first() {
                None => Ok(Vec::new()),
                Some(_) => {
                    let expected =
                        "triangle_materials only beside `mesh`: written-out triangles have no names";
                    Err(Wrong::new("there are no named triangles", expected).key("triangle_materials"))
                }
            };
        };
        let groups = self.loaded(name)?.data.groups.clone();
        let mut all = vec![rest; groups.len()];
        for (group, material) in &spec.0 {
            let surface = self.material(material).key(group).key("triangle_materials")?;
            let Some(n) = groups.iter().position(|g| g == group) else {
                let known = groups.iter().skip(1).map(String::as_str);
                return Err(unknown("material in the mesh file", group, known)
                    .of_key()
                    .key(group)
                    .key("triangle_materials"));
            };
            all[n] = surface;
        }
        Ok(all)
    }
}

/// The kinds of a shape in the order of the file format, and which are given.
fn kinds(s: &ShapeSpec) -> [(&'static str, bool); 11] {
    [
        ("sphere", s.sphere.is_some()),
        ("capsule", s.capsule.is_some()),
        ("box", s.cuboid.is_some()),
        ("cylinder", s.cylinder.is_some()),
        ("cone", s.cone.is_some()),
        ("hull", s.hull.is_some()),
        ("half_space", s.half_space.is_some()),
        ("mesh", s.mesh.is_some()),
        ("height_field", s.height_field.is_some()),
        ("compound", s.compound.is_some()),
        ("decompose", s.decompose.is_some()),
    ]
}

fn used_vertices(data: &MeshData) -> Vec<Vec3> {
    let mut used = vec![false; data.vertices.len()];
    data.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
    data.vertices.iter().zip(used).filter(|(_, u)| *u).map(|(v, _)| *v).collect()
}

fn place(m: &MeshFileSpec, read: &mut impl FnMut(&str) -> Result<MeshData, SceneError>) -> Checked<Loaded> {
    let scale = m.scale.map_or([1.0; 3], |s| s.each());
    if scale.iter().any(|s| !(s.abs() >= 1e-9 && s.abs() <= 1e9)) {
        return Err(Wrong::new(format!("is {scale:?}"), "factors of 1e-9 to 1e9").key("scale"));
    }
    let weld_distance = m.weld_distance.unwrap_or(0.0);
    if !(0.0..=1e3).contains(&weld_distance) {
        return Err(Wrong::new(format!("is {weld_distance}"), "0 to 1000 m").key("weld_distance"));
    }
    let mut data = read(&m.file).map_err(|e| match e {
        SceneError::File { file, message } => {
            Wrong::new(format!("mesh {file}: {message}"), "a mesh file that is there and can be read")
                .key("file")
        }
        // The scene's place, and the mesh file's own complaint with its place there.
        SceneError::Fault(mut f) => {
            let expected = std::mem::take(&mut f.expected);
            Wrong::new(format!("mesh {f}"), expected).key("file")
        }
        e => Wrong::ready(e),
    })?;
    for v in &mut data.vertices {
        let p = Vec3::new(v.x * scale[0], v.y * scale[1], v.z * scale[2]);
        *v = match m.up.unwrap_or(UpSpec::Y) {
            UpSpec::Y => p,
            UpSpec::Z => Vec3::new(p.x, p.z, -p.y),
            UpSpec::X => Vec3::new(-p.y, p.x, p.z),
        };
        if !v.is_finite() {
            return Err(Wrong::new("makes coordinates that are not finite", "a smaller factor").key("scale"));
        }
    }
    if scale[0] * scale[1] * scale[2] < 0.0 {
        data.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    let options = TriMeshOptions { weld_distance, double_sided: m.double_sided.unwrap_or(false) };
    Ok(Loaded { data, options, mesh: None, hull: None })
}

/// Quaternion of `rotation_deg` (about fixed x, then y, then z) or `rotation`.
pub(crate) fn rotation(deg: Option<[f32; 3]>, q: Option<[f32; 4]>) -> Checked<Quat> {
    match (deg, q) {
        (Some(_), Some(_)) => {
            Err(Wrong::new("given beside `rotation_deg`", "rotation or rotation_deg, not both")
                .key("rotation"))
        }
        (Some(d), None) => {
            if d.iter().any(|a| a.abs() > 1e6) {
                return Err(Wrong::new(format!("is {d:?}"), "angles within ±1e6 degrees").key("rotation_deg"));
            }
            Ok(euler(d))
        }
        (None, Some(q)) => {
            let q = Quat::from_array(q);
            let l = q.length();
            if !(l > 1e-6 && l < 1e6) {
                return Err(Wrong::new(
                    format!("has length {l}"),
                    "a quaternion x, y, z, w that is not zero",
                )
                .key("rotation"));
            }
            Ok(q.normalize())
        }
        (None, None) => Ok(Quat::IDENTITY),
    }
}

/// Turns about fixed x, then y, then z, in degrees; computed in double precision, so that 90° is exact in single.
pub(crate) fn euler(deg: [f32; 3]) -> Quat {
    let radians = deg.map(|a| f64::from(a) * (core::f64::consts::PI / 180.0));
    DQuat::from_euler_xyz(DVec3::from_array(radians)).normalize().as_quat()
}

fn pose(s: &ShapeSpec) -> Checked<Pose> {
    Ok(Pose::new(Vec3::from_array(s.position.unwrap_or([0.0; 3])), rotation(s.rotation_deg, s.rotation)?))
}

fn combine(c: CombineSpec) -> Combine {
    match c {
        CombineSpec::GeometricMean => Combine::GeometricMean,
        CombineSpec::Average => Combine::Average,
        CombineSpec::Min => Combine::Min,
        CombineSpec::Multiply => Combine::Multiply,
        CombineSpec::Max => Combine::Max,
    }
}

fn material(m: &MaterialSpec) -> Checked<Material> {
    let d = Material::default();
    let both = [("static_friction", m.static_friction), ("kinetic_friction", m.kinetic_friction)];
    if let (Some(_), Some((key, _))) = (m.friction, both.iter().find(|(_, v)| v.is_some())) {
        return Err(Wrong::new(
            "given beside `friction`",
            "friction, or static_friction and kinetic_friction",
        )
        .key(key));
    }
    let (stick, slide) = (m.static_friction.or(m.friction), m.kinetic_friction.or(m.friction));
    let built = Material {
        static_friction: stick.unwrap_or_else(|| d.static_friction.max(slide.unwrap_or(0.0))),
        kinetic_friction: slide.unwrap_or_else(|| d.kinetic_friction.min(stick.unwrap_or(f32::MAX))),
        restitution: m.restitution.unwrap_or(d.restitution),
        rolling_friction: m.rolling_friction.unwrap_or(d.rolling_friction),
        twist_friction: m.twist_friction.unwrap_or(d.twist_friction),
        surface_velocity: m.surface_velocity.map_or(d.surface_velocity, Vec3::from_array),
        friction_combine: m.friction_combine.map_or(d.friction_combine, combine),
        restitution_combine: m.restitution_combine.map_or(d.restitution_combine, combine),
    };
    match built.check() {
        Err(jounce::Error::BadValue { value, expected, .. })
            if m.friction.is_some_and(|f| !(0.0..=1e4).contains(&f)) =>
        {
            Err(Wrong::new(format!("is {value}"), expected).key("friction"))
        }
        other => other.map(|()| built).map_err(Wrong::from),
    }
}

fn height_field(h: &HeightFieldSpec, samples: &mut usize) -> Checked<HeightField> {
    build_height_field(h, samples).key("height_field")
}

fn build_height_field(h: &HeightFieldSpec, samples: &mut usize) -> Checked<HeightField> {
    let side = |key: &str, n: u64| match usize::try_from(n) {
        Ok(n) if (2..=bounds::HEIGHT_FIELD_SIDE_MAX).contains(&n) => Ok(n),
        _ => Err(Wrong::new(format!("is {n}"), format!("2 to {}", bounds::HEIGHT_FIELD_SIDE_MAX)).key(key)),
    };
    let (columns, rows) = (side("columns", h.columns)?, side("rows", h.rows)?);
    let spacing = h.spacing.map_or([1.0; 2], |s| s.each());
    if spacing.iter().any(|s| !(*s >= bounds::SIZE_MIN && *s <= bounds::SIZE_MAX)) {
        return Err(Wrong::new(format!("is {spacing:?}"), "1e-6 to 1e6 m").key("spacing"));
    }
    let heights = match (&h.heights, h.function) {
        (Some(list), None) => {
            if list.len() != columns * rows {
                let message = format!("has {} numbers", list.len());
                return Err(
                    Wrong::new(message, format!("columns × rows = {}", columns * rows)).key("heights")
                );
            }
            list.iter().map(|y| y.unwrap_or(f32::NAN)).collect()
        }
        (None, Some(f)) => {
            let limit =
                || format!("at most {} samples in the scene's functions", crate::limits::HEIGHT_SAMPLES_MAX);
            let left = samples.checked_sub(columns * rows);
            *samples = left.ok_or_else(|| {
                Wrong::new(format!("makes {} samples", columns * rows), limit()).key("function")
            })?;
            heights_of(h, f, [columns, rows], spacing)?
        }
        _ => return Err(Wrong::new("needs heights", "exactly one of heights, function")),
    };
    HeightField::new(columns, rows, spacing, heights).map_err(|e| {
        // The caller adds the shape's key.
        Wrong::new(e.to_string(), "")
    })
}

fn heights_of(
    h: &HeightFieldSpec,
    function: HeightFunctionSpec,
    n: [usize; 2],
    spacing: [f32; 2],
) -> Checked<Vec<f32>> {
    let amplitude = f64::from(h.amplitude.unwrap_or(1.0));
    if amplitude.abs() > 1e5 {
        return Err(Wrong::new(format!("is {amplitude}"), "within ±1e5 m").key("amplitude"));
    }
    let size: [f64; 2] = core::array::from_fn(|k| f64::from(spacing[k]) * (n[k] - 1) as f64);
    let wavelength = f64::from(h.wavelength.unwrap_or(8.0 * spacing[0]));
    if !(1e-6..=1e7).contains(&wavelength) {
        return Err(Wrong::new(format!("is {wavelength}"), "1e-6 to 1e7 m").key("wavelength"));
    }
    let octaves = h.octaves.unwrap_or(4);
    if !(1..=8).contains(&octaves) {
        return Err(Wrong::new(format!("is {octaves}"), "1 to 8").key("octaves"));
    }
    let seed = h.seed.unwrap_or(0);
    let turn = 2.0 * core::f64::consts::PI / wavelength;
    let radius = f64s::min(size[0], size[1]) * 0.5;
    let height = |x: f64, z: f64| match function {
        HeightFunctionSpec::Flat => 0.0,
        HeightFunctionSpec::Waves => f64s::sin(turn * x) * f64s::sin(turn * z),
        HeightFunctionSpec::Bowl => (x * x + z * z) / (radius * radius),
        HeightFunctionSpec::Noise => {
            let (mut sum, mut weight, mut scale) = (0.0, 0.5, 1.0 / wavelength);
            for o in 0..octaves {
                sum += weight * noise(seed, u64::from(o), x * scale, z * scale);
                (weight, scale) = (0.5 * weight, 2.0 * scale);
            }
            sum
        }
    };
    let mut heights = Vec::with_capacity(n[0] * n[1]);
    for j in 0..n[1] {
        for i in 0..n[0] {
            let x = i as f64 * f64::from(spacing[0]) - 0.5 * size[0];
            let z = j as f64 * f64::from(spacing[1]) - 0.5 * size[1];
            heights.push((amplitude * height(x, z)) as f32);
        }
    }
    Ok(heights)
}

/// The solver's constants with what the scene says.
pub(crate) fn settings(s: &SettingsSpec) -> Settings {
    let d = Settings::default();
    Settings {
        length_unit: s.length_unit.unwrap_or(d.length_unit),
        contact_hertz: s.contact_hertz.unwrap_or(d.contact_hertz),
        contact_damping_ratio: s.contact_damping_ratio.unwrap_or(d.contact_damping_ratio),
        static_contact_hertz: s.static_contact_hertz.unwrap_or(d.static_contact_hertz),
        static_contact_damping_ratio: s
            .static_contact_damping_ratio
            .unwrap_or(d.static_contact_damping_ratio),
        push_out_speed: s.push_out_speed.unwrap_or(d.push_out_speed),
        restitution_speed: s.restitution_speed.unwrap_or(d.restitution_speed),
        stick_speed: s.stick_speed.unwrap_or(d.stick_speed),
        hit_event_speed: s.hit_event_speed.unwrap_or(d.hit_event_speed),
        sleep: s.sleep.unwrap_or(d.sleep),
        sleep_speed: s.sleep_speed.unwrap_or(d.sleep_speed),
        sleep_time_s: s.sleep_time_s.unwrap_or(d.sleep_time_s),
        joint_hertz: s.joint_hertz.unwrap_or(d.joint_hertz),
        joint_damping_ratio: s.joint_damping_ratio.unwrap_or(d.joint_damping_ratio),
        continuous: s.continuous.unwrap_or(d.continuous),
        warm_starting: s.warm_starting.unwrap_or(d.warm_starting),
        recycle_contacts: s.recycle_contacts.unwrap_or(d.recycle_contacts),
        linear_speed_max: s.linear_speed_max.unwrap_or(d.linear_speed_max),
        rotation_per_step_max: s.rotation_per_step_max.unwrap_or(d.rotation_per_step_max),
    }
}

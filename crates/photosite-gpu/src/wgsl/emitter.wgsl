// Shapes that emit, as they are seen from a point; photosite-transport's light/emissive_triangle.rs, light/emitter.

struct SeenPoint {
    position: vec3<f32>,
    normal: vec3<f32>,
    parameters: vec2<f32>,
    wi: vec3<f32>,
    /// Cosine to the normal, positive where the front is seen.
    cosine: f32,
    /// Density of the direction; 0 where light sampling leaves the shape to BSDF sampling.
    pdf: f32,
}

struct EmissiveTriangle {
    corner: vec3<f32>,
    double_area: f32,
    first_edge: vec3<f32>,
    second_edge: vec3<f32>,
}

fn emissive_triangle(light: u32) -> EmissiveTriangle {
    let at = params.lights + light * LIGHT_WORDS;
    let corner = bitcast<vec4<f32>>(tables[at + 3u]);
    return EmissiveTriangle(corner.xyz, corner.w, bitcast<vec3<f32>>(tables[at + 4u].xyz), bitcast<vec3<f32>>(tables[at + 5u].xyz));
}

/// The triangle of a light that changes its shape, at a time.
fn emissive_triangle_at(light: u32, time: f32) -> EmissiveTriangle {
    let shapes = tables[params.lights + light * LIGHT_WORDS + 3u];
    let corners = emissive_corners_at(shapes.x, shapes.y, time);
    let first_edge = corners.b - corners.a;
    let second_edge = corners.c - corners.a;
    return EmissiveTriangle(corners.a, length(cross(first_edge, second_edge)), first_edge, second_edge);
}

fn seen_point(position: vec3<f32>, normal: vec3<f32>, parameters: vec2<f32>, seer: vec3<f32>, pdf_of_area: f32) -> SeenPoint {
    let towards = position - seer;
    let distance_squared = dot(towards, towards);
    let wi = towards / sqrt(distance_squared);
    let cosine = -dot(normal, wi);
    return SeenPoint(position, normal, parameters, wi, cosine, to_solid_angle(pdf_of_area, distance_squared, abs(cosine)));
}

fn sample_emissive_triangle(shape: EmissiveTriangle, seer: vec3<f32>, u: vec2<f32>) -> SeenPoint {
    let b = uniform_triangle(u);
    let position = shape.corner + shape.first_edge * b.x + shape.second_edge * b.y;
    let normal = cross(shape.first_edge, shape.second_edge) / shape.double_area;
    return seen_point(position, normal, b, seer, 2.0 / shape.double_area);
}

fn nothing_seen() -> SeenPoint {
    return SeenPoint(vec3<f32>(0.0), vec3<f32>(0.0), vec2<f32>(0.0), vec3<f32>(0.0), 0.0, 0.0);
}

/// A sphere as it is seen from a point; `View` of light/emitter/sphere.rs.
struct SphereView {
    away: vec3<f32>,
    distance: f32,
    beyond: f32,
    /// Height of the cone, 1 − cos; 0 where the point is on the surface.
    height: f32,
}

fn sphere_view(sphere: Quadric, seer: vec3<f32>) -> SphereView {
    let from_centre = seer - sphere.place;
    let distance = length(from_centre);
    let outside = distance - sphere.radius;
    let size = abs(sphere.place);
    if (abs(outside) <= (max(size.x, max(size.y, size.z)) + sphere.radius) * gamma(16.0)) {
        return SphereView(vec3<f32>(0.0, 0.0, 1.0), distance, 0.0, 0.0);
    }
    let beyond = outside * (distance + sphere.radius);
    let sine = sphere.radius / distance;
    let height = select(2.0, sine * sine / (1.0 + sqrt(max(beyond, 0.0)) / distance), outside > 0.0);
    return SphereView(select(vec3<f32>(0.0, 0.0, 1.0), from_centre / distance, distance > 0.0), distance, beyond, height);
}

fn sample_sphere(sphere: Quadric, seer: vec3<f32>, u: vec2<f32>) -> SeenPoint {
    let view = sphere_view(sphere, seer);
    if (view.height == 0.0) {
        return nothing_seen();
    }
    let is_inside = view.beyond < 0.0;
    let height = u.x * view.height;
    let cosine = 1.0 - height;
    let sin2 = height * (2.0 - height);
    let sine = sqrt(sin2);
    let ratio = view.distance / sphere.radius;
    let cos_at_sphere = sqrt(max(1.0 - sin2 * ratio * ratio, 0.0));
    let along = view.distance * cosine;
    let half_chord = sphere.radius * cos_at_sphere;
    var t = abs(view.beyond) / (abs(along) + half_chord);
    if (is_inside && along > 0.0) {
        t = along + half_chord;
    }
    let turn = sin_cos_turn(u.y);
    let wi = to_world(frame_from_normal(-view.away), vec3<f32>(sine * turn.y, sine * turn.x, cosine));
    let parameters = sphere_parameters(view.away * view.distance + wi * t);
    let point = quadric_point(sphere, parameters);
    let pdf = 0.5 * FRAC_1_PI / view.height;
    return SeenPoint(point.position, point.normal, parameters, wi, select(cos_at_sphere, -cos_at_sphere, is_inside), pdf);
}

/// The part of a cylinder that may be seen from a point; `VisibleArc`.
struct VisibleArc {
    middle: vec2<f32>,
    /// 0 from the surface itself.
    half_angle: f32,
    is_inside: bool,
}

fn visible_arc(cylinder: Quadric, seer: vec3<f32>) -> VisibleArc {
    let from_middle = seer - cylinder.place;
    let across = vec2<f32>(dot(from_middle, cylinder.x), dot(from_middle, cylinder.y));
    let distance = length(across);
    let outside = distance - cylinder.radius;
    let place = abs(cylinder.place);
    let size = abs(from_middle);
    let rounding = max(place.x, max(place.y, place.z)) + max(size.x, max(size.y, size.z)) + cylinder.radius;
    if (abs(outside) <= rounding * gamma(16.0)) {
        return VisibleArc(vec2<f32>(1.0, 0.0), 0.0, false);
    }
    let is_inside = outside < 0.0;
    let half_angle = atan2(sqrt(max(outside, 0.0) * (distance + cylinder.radius)), cylinder.radius);
    return VisibleArc(select(across / distance, vec2<f32>(1.0, 0.0), is_inside), select(half_angle, PI, is_inside), is_inside);
}

fn arc_pdf(arc: VisibleArc, cylinder: Quadric) -> f32 {
    return 0.25 / (arc.half_angle * cylinder.radius * cylinder.half_length);
}

fn sample_cylinder(cylinder: Quadric, seer: vec3<f32>, u: vec2<f32>) -> SeenPoint {
    let arc = visible_arc(cylinder, seer);
    if (arc.half_angle == 0.0) {
        return nothing_seen();
    }
    let angle = arc.half_angle * (2.0 * u.x - 1.0);
    let c = cos(angle);
    let s = sin(angle);
    let across = vec2<f32>(arc.middle.x * c - arc.middle.y * s, arc.middle.x * s + arc.middle.y * c);
    let parameters = vec2<f32>(cylinder_parameter(across), 2.0 * u.y - 1.0);
    let point = quadric_point(cylinder, parameters);
    var seen = seen_point(point.position, point.normal, parameters, seer, arc_pdf(arc, cylinder));
    seen.pdf = select(0.0, seen.pdf, arc.is_inside == (seen.cosine < 0.0));
    return seen;
}

fn sample_quadric(quadric: Quadric, seer: vec3<f32>, u: vec2<f32>) -> SeenPoint {
    switch quadric.kind {
        case SPHERE: { return sample_sphere(quadric, seer, u); }
        case DISK: {
            let parameters = concentric_disk(u);
            let point = quadric_point(quadric, parameters);
            return seen_point(point.position, point.normal, parameters, seer, 1.0 / (PI * quadric.radius * quadric.radius));
        }
        default: { return sample_cylinder(quadric, seer, u); }
    }
}

/// Density with which a shape's samples at a time give a point at a distance, seen with a cosine of either sign.
fn emitter_pdf(kind: u32, number: u32, light: u32, seer: vec3<f32>, time: f32, distance: f32, cosine: f32) -> f32 {
    let distance2 = distance * distance;
    if (kind == LIGHT_TRIANGLE) {
        return to_solid_angle(2.0 / emissive_triangle(light).double_area, distance2, abs(cosine));
    }
    if (kind == LIGHT_DEFORMING) {
        return to_solid_angle(2.0 / emissive_triangle_at(light, time).double_area, distance2, abs(cosine));
    }
    if (kind != LIGHT_QUADRIC) {
        return 0.0;
    }
    let quadric = load_quadric(number);
    if (quadric.kind == DISK) {
        return to_solid_angle(1.0 / (PI * quadric.radius * quadric.radius), distance2, abs(cosine));
    }
    if (quadric.kind == SPHERE) {
        let view = sphere_view(quadric, seer);
        let is_seen = view.height > 0.0 && (view.beyond < 0.0) == (cosine < 0.0);
        return select(0.0, 0.5 * FRAC_1_PI / view.height, is_seen);
    }
    let arc = visible_arc(quadric, seer);
    let is_seen = arc.half_angle > 0.0 && arc.is_inside == (cosine < 0.0);
    return select(0.0, to_solid_angle(arc_pdf(arc, quadric), distance2, abs(cosine)), is_seen);
}

// Shadow rays through panes to lights without a surface; photosite-transport's scene/panes.rs.

const HAS_PANES = (SCENE_FEATURES & PANES) != 0u;

/// The part of the light that arrives against a shadow ray from a light without a surface: panes and the boundaries of
/// volumes of index 1 let some of it straight through, and nothing else in the way lets any. Volumes absorb on the way; the
/// ray sets out in a medium.
fn through_panes(shadow_ray: Ray, first_medium: u32, lambda_nm: vec4<f32>) -> vec4<f32> {
    let is_distant = shadow_ray.t_max == FAR;
    let end = shadow_ray.origin + shadow_ray.direction;
    let towards = normalize(shadow_ray.direction);
    var ray = shadow_ray;
    var medium = first_medium;
    var passed = vec4<f32>(1.0);
    loop {
        let hit = trace(ray, false);
        if (hit.slot == NONE) {
            if (HAS_MEDIA && !is_distant) {
                passed *= transmittance(medium, distance(end, ray.origin), lambda_nm);
            }
            break;
        }
        let point = surface_point(hit, shadow_ray.time);
        if (HAS_MEDIA) {
            let behind = absorption_behind(point, -towards);
            medium = select(behind, medium, behind == NONE);
            passed *= transmittance(medium, distance(point.position, ray.origin), lambda_nm);
        }
        let shading = shading_at(point, -towards, lambda_nm);
        passed *= straight(shading.bsdf, to_local(shading.frame, -towards));
        if (all(passed == vec4<f32>(0.0))) {
            break;
        }
        if (HAS_MEDIA) {
            medium = medium_across(point, towards, medium);
        }
        ray = spawn_ray(point, towards);
        if (is_distant) {
            ray.direction = shadow_ray.direction;
        } else {
            ray.direction = end - ray.origin;
            ray.t_max = 1.0;
        }
        // A pane at the light itself.
        if (dot(ray.direction, towards) <= 0.0) {
            break;
        }
    }
    return passed;
}

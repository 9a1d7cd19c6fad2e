//! Layout of the EuRoC data sets, also called ASL ([Euroc](photosite_core::references#euroc)):
//!
//! ```text
//! mav0/body.yaml
//! mav0/cam0/{data.csv, sensor.yaml, data/NS.png}
//! mav0/state_groundtruth_estimate0/{data.csv, sensor.yaml}
//! ```
//!
//! Images are 8-bit grey and named by their time stamps. The body B is the first camera, so that its `T_BS` is the
//! identity. The state is that of the body in the world at the stamps of the first camera: p_RS_R and q_RS lead from
//! the body to the world, v_RS_R is its velocity; the biases are those of no instrument and 0.

use glam::DQuat;

use super::super::camera_files::{euroc, opencv_pose};
use super::image_set::{ImageSet, LayoutFiles};
use photosite_core::Result;

pub(super) fn write(set: &ImageSet, files: &mut dyn LayoutFiles) -> Result<()> {
    let rig = set.rig().map_err(|invalid| set.error(invalid))?;
    let Some(body) = rig.first().map(|camera| opencv_pose(&camera.to_world)) else { return Ok(()) };
    let sensors: Vec<String> = rig
        .iter()
        .map(|camera| euroc(camera, &body, rate_hz(set)))
        .collect::<Result<_, _>>()
        .map_err(|invalid| set.error(invalid))?;
    files.write_text("mav0/body.yaml", "comment: \"The body is cam0\"\n")?;
    for (i, sensor) in sensors.iter().enumerate() {
        files.write_text(&format!("mav0/cam{i}/sensor.yaml"), sensor)?;
        let mut list = "#timestamp [ns],filename\n".to_owned();
        for shot in set.of_camera(i) {
            let name = format!("{}.png", shot.stamp_ns);
            list += &format!("{},{name}\n", shot.stamp_ns);
            files.write_grey_image(&format!("mav0/cam{i}/data/{name}"), shot)?;
        }
        files.write_text(&format!("mav0/cam{i}/data.csv"), &list)?;
    }
    let truth = "sensor_type: visual-inertial\ncomment: \"The true pose of cam0 in the world, y up\"\nT_BS:\n  cols: 4\n  rows: 4\n  \
                 data: [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]\n";
    files.write_text("mav0/state_groundtruth_estimate0/sensor.yaml", truth)?;
    files.write_text("mav0/state_groundtruth_estimate0/data.csv", &states(set))
}

const STATE: &str = "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], \
    v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], \
    b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]\n";

fn states(set: &ImageSet) -> String {
    let mut text = STATE.to_owned();
    for shot in set.of_camera(0) {
        let pose = opencv_pose(&shot.calibrated.to_world);
        let q = DQuat::from_mat3(&pose.matrix3).normalize();
        let [p, v] = [pose.translation, shot.velocity_m_per_s].map(|v| v.to_array());
        let numbers = p.into_iter().chain([q.w, q.x, q.y, q.z]).chain(v).chain([0.0; 6]);
        text += &shot.stamp_ns.to_string();
        // Adding zero makes zeros of negative ones.
        numbers.for_each(|x| text += &format!(",{}", x + 0.0));
        text.push('\n');
    }
    text
}

/// Frame rate from the first and the last time stamp, Hz; 1 for a single frame.
fn rate_hz(set: &ImageSet) -> f64 {
    let stamps: Vec<u64> = set.of_camera(0).map(|shot| shot.stamp_ns).collect();
    match stamps.as_slice() {
        [first, .., last] if last > first => (stamps.len() - 1) as f64 * 1e9 / (last - first) as f64,
        _ => 1.0,
    }
}

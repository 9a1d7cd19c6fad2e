//! Origin of a change to the capture: the key of the data set file that asks for it.

use super::DatasetDescription;
use photosite_core::key_path::{path_matches, split_change};

impl DatasetDescription {
    /// Key that asks for a change (`key=value`) to the capture of camera `camera` of the rig; `None` for changes that
    /// every data set makes.
    pub fn key_of(&self, camera: usize, change: &str) -> Option<String> {
        let key = split_change(change).map_or(change, |(key, _)| key);
        let of_rig = self.cameras.get(camera);
        let among = |set: &[String]| set.iter().rposition(|other| other == change);
        if let Some(i) = of_rig.and_then(|camera| among(&camera.set)) {
            return Some(format!("cameras[{camera}].set[{i}]"));
        }
        if let Some(i) = among(&self.set) {
            return Some(format!("set[{i}]"));
        }
        if let Some(i) = self.vary.iter().rposition(|v| v.keys().any(|pattern| path_matches(pattern, key))) {
            return Some(format!("vary[{i}]"));
        }
        match key {
            "output.truth_partner" => of_rig?.disparity_to.as_ref().map(|_| format!("cameras[{camera}].disparity_to")),
            "render.seed" => self.seed.map(|_| "seed".to_owned()),
            "camera.position_m" | "camera.look_at_m" | "camera.up" | "camera.motion" | "exposure.frame_interval_s" => {
                self.key_of_pose().or_else(|| of_rig.map(|_| format!("cameras[{camera}]")))
            }
            "lens.focal_length_mm" => self.key_of_pose(),
            "scene.objects" => match self.place.len() {
                0 => None,
                1 => Some("place[0]".to_owned()),
                _ => Some("place".to_owned()),
            },
            _ => None,
        }
    }

    /// Key that sets the pose of the rig.
    fn key_of_pose(&self) -> Option<String> {
        let poses = self.poses.as_ref()?;
        let kinds = [
            ("list", poses.list.is_some()),
            ("grid", poses.grid.is_some()),
            ("random", poses.random.is_some()),
            ("trajectory", poses.trajectory.is_some()),
        ];
        let kind = kinds.into_iter().find(|(_, is_given)| *is_given);
        Some(kind.map_or_else(|| "poses".to_owned(), |(kind, _)| format!("poses.{kind}")))
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn every_change_leads_to_its_key() {
        let description: DatasetDescription = serde_json::from_value(json!({
            "capture": "a.toml",
            "seed": 3,
            "set": ["a.b=1", "a.c=2"],
            "cameras": [{ "name": "left" }, { "name": "right", "disparity_to": "left", "set": ["a.c=2"] }],
            "poses": { "trajectory": { "frame_rate_hz": 10, "poses": [] } },
            "vary": [
                { "key": "a.d", "uniform": [0, 1] },
                { "key": "m.paint-*.x", "uniform": [0, 1] },
                { "choices": [{ "b.c": 1, "b.d": 2 }] },
            ],
            "place": [{ "objects": ["a.glb"], "method": "drop" }],
        }))
        .expect("a description");
        for (camera, change, key) in [
            (0, "a.c=2", Some("set[1]")),
            (1, "a.c=2", Some("cameras[1].set[0]")),
            (1, "a.d=0.25", Some("vary[0]")),
            (0, "m.\"paint-a=b\".x=0.25", Some("vary[1]")),
            (0, "b.d=2", Some("vary[2]")),
            (0, "camera.motion={ poses = [] }", Some("poses.trajectory")),
            (0, "exposure.frame_interval_s=0.1", Some("poses.trajectory")),
            (1, "output.truth_partner={ up = [0, 1, 0] }", Some("cameras[1].disparity_to")),
            (0, "render.seed=17", Some("seed")),
            (1, "scene.objects=[]", Some("place[0]")),
            (0, "develop.distortion=false", None),
        ] {
            assert_eq!(description.key_of(camera, change).as_deref(), key, "{change}");
        }
        let standing = DatasetDescription { poses: None, ..description };
        assert_eq!(standing.key_of(1, "camera.position_m=[0, 0, 0]").as_deref(), Some("cameras[1]"));
    }
}

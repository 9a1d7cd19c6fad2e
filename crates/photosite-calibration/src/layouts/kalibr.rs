//! Input of `kalibr_bagcreater`, with the results that a calibration of the bag should find
//! ([Kalibr](photosite_core::references#kalibr), "Bag format", "Calibration targets", "YAML formats"):
//!
//! ```text
//! cam0/NS.png …
//! camchain.yaml
//! target-NAME.yaml
//! ```
//!
//! Images are 8-bit grey and named by their time stamps. There is a file for each target of a kind that Kalibr
//! detects: aprilgrid, checkerboard (whose rows and columns count inner corners), symmetric circle grid.

use std::collections::BTreeMap;

use super::super::camera_files::kalibr;
use super::super::camera_files::yaml::number;
use super::super::targets::TargetDescription;
use super::image_set::{ImageSet, LayoutFiles};
use photosite_core::Result;

pub(super) fn write(set: &ImageSet, files: &mut dyn LayoutFiles) -> Result<()> {
    let rig = set.rig().map_err(|invalid| set.error(invalid))?;
    let chain = kalibr(&rig).map_err(|invalid| set.error(invalid))?;
    files.write_text("camchain.yaml", &chain)?;
    for (name, text) in targets(set) {
        files.write_text(&name, &text)?;
    }
    for shot in &set.shots {
        files.write_grey_image(&format!("cam{}/{}.png", shot.camera, shot.stamp_ns), shot)?;
    }
    Ok(())
}

/// Target files by name.
fn targets(set: &ImageSet) -> BTreeMap<String, String> {
    let all = set.shots.iter().flat_map(|shot| &shot.targets);
    let file = |target: &super::SeenTarget| {
        let plain: String = target.name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
        Some((format!("target-{plain}.yaml"), target_file(&target.description)?))
    };
    all.filter_map(file).collect()
}

/// Kalibr's description of a target; `None` for a target that Kalibr does not detect.
fn target_file(target: &TargetDescription) -> Option<String> {
    let metres = |mm: f64| number(mm / 1e3);
    match target {
        TargetDescription::AprilGrid(grid) => {
            let ([columns, rows], side, spacing) = (grid.tags, metres(grid.tag_mm), number(grid.spacing));
            Some(format!(
                "target_type: 'aprilgrid'\ntagCols: {columns}\ntagRows: {rows}\ntagSize: {side}\ntagSpacing: {spacing}\n"
            ))
        }
        TargetDescription::Chessboard(board) => {
            let ([columns, rows], side) = (board.squares.map(|squares| squares - 1), metres(board.square_mm));
            Some(format!(
                "target_type: 'checkerboard'\ntargetCols: {columns}\ntargetRows: {rows}\nrowSpacingMeters: {side}\n\
                 colSpacingMeters: {side}\n"
            ))
        }
        TargetDescription::CircleGrid(grid) => {
            let ([columns, rows], spacing) = (grid.circles, metres(grid.spacing_mm));
            Some(format!(
                "target_type: 'circlegrid'\ntargetCols: {columns}\ntargetRows: {rows}\nspacingMeters: {spacing}\n\
                 asymmetricGrid: False\n"
            ))
        }
        TargetDescription::Charuco(_)
        | TargetDescription::MarkerGrid(_)
        | TargetDescription::AsymmetricCircleGrid(_)
        | TargetDescription::DotChart(_)
        | TargetDescription::SlantedEdge(_)
        | TargetDescription::EsfrChart(_)
        | TargetDescription::SiemensStar(_)
        | TargetDescription::ColourChecker(_)
        | TargetDescription::GreyWedge(_)
        | TargetDescription::Flat(_) => None,
    }
}

//! Matrices as reports state them: lists of rows.

use glam::{DAffine3, DMat3, DVec3};

/// Rows of the matrix [R t].
pub(super) fn placement(to_world: &DAffine3) -> [[f64; 4]; 3] {
    let (rotation, t) = (rows(to_world.matrix3), to_world.translation);
    [0, 1, 2].map(|i| [rotation[i][0], rotation[i][1], rotation[i][2], t[i] + 0.0])
}

/// Rows of a matrix. Adding zero makes zeros of negative ones.
pub fn rows(m: DMat3) -> [[f64; 3]; 3] {
    m.transpose().to_cols_array_2d().map(|row| row.map(|x| x + 0.0))
}

/// Matrix of these rows.
pub(super) fn from_rows(rows: &[[f64; 3]; 3]) -> DMat3 {
    DMat3::from_cols_array_2d(rows).transpose()
}

/// Transform of the rows [R t].
pub(super) fn affine(rows: &[[f64; 4]; 3]) -> DAffine3 {
    let matrix = from_rows(&rows.map(|[x, y, z, _]| [x, y, z]));
    DAffine3::from_mat3_translation(matrix, DVec3::from_array(rows.map(|[.., t]| t)))
}

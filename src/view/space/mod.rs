//! Maps of where hands can get to: as slices for report and picture, as a cloud about a body, and as a file of VTK.

pub mod slices;
pub mod vtk;

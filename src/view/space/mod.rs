//! Maps of where hands can get to: as slices for report and picture, and as a file of VTK.

pub mod slices;
pub mod vtk;

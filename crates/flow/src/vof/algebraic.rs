//! stub
use super::*;
/// stub
#[derive(Clone, Debug, PartialEq, Default)]
pub struct AlgebraicParams {}
/// stub
pub struct Algebraic {
    /// stub
    pub alpha_phi: FaceField<f64>,
}
impl Algebraic {
    /// stub
    pub fn new(_: &Exec, m: &Mesh, _: AlgebraicParams) -> Result<Self, VofError> {
        Ok(Algebraic { alpha_phi: FaceField::new(m, "a", granflow_base::Dims::VOLUME_FLUX, 0.0) })
    }
    /// stub
    pub fn advance(&mut self, _: &Exec, _: &Mesh, _: &mut Unknown<f64>, _: &FaceField<f64>, _: f64, _: &Surroundings<'_>) -> Result<VofReport, VofError> {
        Ok(VofReport::default())
    }
}

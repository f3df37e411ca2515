//! Conditions of OpenFOAM v1912 that are known and not there, with the reason.

/// Why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// It belongs to a mesh that moves.
    MovingMesh,
    /// It belongs to a model of turbulence.
    Turbulence,
    /// It belongs to gases whose density changes.
    Compressible,
    /// It holds code that would have to be compiled.
    Code,
    /// It takes values from other places of the mesh, or joins faces that do not match.
    Mapping,
    /// It makes a jump across a pair of patches or a baffle.
    Jump,
    /// It goes with the type of the patch.
    PatchType,
    /// A rotating frame of the whole domain.
    Frame,
    /// Nobody has written it yet.
    NotDone,
}

impl Reason {
    /// In a message.
    pub fn text(self) -> &'static str {
        match self {
            Reason::MovingMesh => "it needs a moving mesh, and meshes stand here",
            Reason::Turbulence => "it belongs to turbulence, and flows are laminar here",
            Reason::Compressible => "it belongs to compressible flow",
            Reason::Code => "it holds code that would have to be compiled",
            Reason::Mapping => "it takes values from elsewhere in the mesh",
            Reason::Jump => "it makes a jump across a surface inside the domain",
            Reason::PatchType => "it goes with a patch of its own type",
            Reason::Frame => "rotating frames of the whole domain are not there",
            Reason::NotDone => "it is not done yet",
        }
    }
}

/// A condition that is refused by name.
#[derive(Clone, Copy, Debug)]
pub struct Refused {
    /// The name.
    pub name: &'static str,
    /// Why.
    pub reason: Reason,
    /// What to write instead; empty where nothing does the same.
    pub remedy: &'static str,
}

const fn no(name: &'static str, reason: Reason) -> Refused {
    Refused { name, reason, remedy: "" }
}
const fn but(name: &'static str, reason: Reason, remedy: &'static str) -> Refused {
    Refused { name, reason, remedy }
}

const FUNCTION: &str = "`uniformFixedValue` takes a function of time, `fixedProfile` one of a distance, \
                        `exprFixedValue` a formula, `timeVaryingMappedFixedValue` values from files";
const OWN_TYPE: &str = "give the patch this type in the mesh";

/// All of them, by name.
#[rustfmt::skip]
pub const REFUSED: &[Refused] = &[
    no("SRFFreestreamVelocity", Reason::Frame),
    no("SRFVelocity", Reason::Frame),
    no("SRFWallVelocity", Reason::Frame),
    no("activeBaffleVelocity", Reason::MovingMesh),
    no("activePressureForceBaffleVelocity", Reason::MovingMesh),
    but("advective", Reason::NotDone, "`inletOutlet` lets out what arrives"),
    but("codedFixedValue", Reason::Code, FUNCTION),
    but("codedMixed", Reason::Code, FUNCTION),
    no("compressible::alphatWallFunction", Reason::Turbulence),
    no("cyclicACMI", Reason::Mapping),
    but("cyclicAMI", Reason::Mapping, "`cyclic` joins patches whose faces match"),
    but("cyclicSlip", Reason::PatchType, OWN_TYPE),
    no("directionMixed", Reason::NotDone),
    but("dynamicAlphaContactAngle", Reason::NotDone, "`constantAlphaContactAngle`"),
    no("externalCoupled", Reason::Code),
    no("fan", Reason::Jump),
    but("fanPressure", Reason::NotDone, "`uniformTotalPressure` with a function of time"),
    but("fixedFluxExtrapolatedPressure", Reason::NotDone, "`fixedFluxPressure`"),
    no("fixedInternalValue", Reason::NotDone),
    no("fixedJump", Reason::Jump),
    no("fixedJumpAMI", Reason::Jump),
    no("fixedPressureCompressibleDensity", Reason::Compressible),
    but("fluxCorrectedVelocity", Reason::NotDone, "`pressureInletOutletVelocity`"),
    no("freeSurfacePressure", Reason::MovingMesh),
    no("freeSurfaceVelocity", Reason::MovingMesh),
    no("inletOutletTotalTemperature", Reason::Compressible),
    no("interfaceCompression", Reason::NotDone),
    no("interstitialInletVelocity", Reason::NotDone),
    no("mapped", Reason::Mapping),
    no("mappedField", Reason::Mapping),
    no("mappedFixedInternalValue", Reason::Mapping),
    no("mappedFixedPushedInternalValue", Reason::Mapping),
    no("mappedFlowRate", Reason::Mapping),
    no("mappedVelocityFlux", Reason::Mapping),
    but("matchedFlowRateOutletVelocity", Reason::Mapping, "`flowRateOutletVelocity` with the rate of the inlet"),
    no("nonuniformTransformCyclic", Reason::PatchType),
    but("oscillatingFixedValue", Reason::NotDone, "`uniformFixedValue` with `uniformValue { type sine; ... }`"),
    but("outletMappedUniformInlet", Reason::Mapping, "`uniformFixedValue`"),
    no("overset", Reason::MovingMesh),
    no("plenumPressure", Reason::Compressible),
    but("pressurePIDControlInletVelocity", Reason::NotDone, "`flowRateInletVelocity`"),
    but("prghTotalHydrostaticPressure", Reason::NotDone, "`prghTotalPressure`"),
    no("processor", Reason::PatchType),
    no("processorCyclic", Reason::PatchType),
    no("sliced", Reason::NotDone),
    no("supersonicFreestream", Reason::Compressible),
    no("swirlFanVelocity", Reason::Jump),
    no("syringePressure", Reason::MovingMesh),
    but("timeVaryingAlphaContactAngle", Reason::NotDone, "`constantAlphaContactAngle`"),
    but("timeVaryingUniformFixedValue", Reason::NotDone, "`uniformFixedValue` with `uniformValue { type tableFile; ... }`"),
    no("totalTemperature", Reason::Compressible),
    no("turbulentDFSEMInlet", Reason::Turbulence),
    no("turbulentDigitalFilterInlet", Reason::Turbulence),
    no("turbulentInlet", Reason::Turbulence),
    no("turbulentIntensityKineticEnergyInlet", Reason::Turbulence),
    no("uniformJump", Reason::Jump),
    no("uniformJumpAMI", Reason::Jump),
    but("waveMaker", Reason::MovingMesh, "`waveVelocity` and `waveAlpha` make waves at a patch that stands"),
    no("waveSurfacePressure", Reason::MovingMesh),
    but("waveTransmissive", Reason::Compressible, "`inletOutlet` lets out what arrives"),
];

/// Conditions by which patches close themselves.
const OF_PATCHES: &[&str] = &["cyclic", "empty", "symmetry", "symmetryPlane", "wedge"];

/// The entry of `name`, if it is one of them.
pub fn refused(name: &str) -> Option<Refused> {
    if let Some(found) = REFUSED.iter().find(|x| x.name == name) {
        return Some(*found);
    }
    if let Some(name) = OF_PATCHES.iter().find(|n| **n == name) {
        return Some(but(name, Reason::PatchType, OWN_TYPE));
    }
    let turbulent = name.ends_with("WallFunction") || name.starts_with("turbulent");
    turbulent.then_some(no("", Reason::Turbulence))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conditions::ALL;
    use crate::conditions::testing::*;

    /// What icoFoam of v1912 names as valid for U and p.
    const VECTORS: &str = "SRFFreestreamVelocity SRFVelocity SRFWallVelocity activeBaffleVelocity \
        activePressureForceBaffleVelocity advective calculated codedFixedValue codedMixed cyclic \
        cyclicACMI cyclicAMI cyclicSlip cylindricalInletVelocity directionMixed empty exprFixedValue \
        exprMixed extrapolatedCalculated fixedGradient fixedInternalValue fixedJump fixedJumpAMI \
        fixedMean fixedMeanOutletInlet fixedNormalInletOutletVelocity fixedNormalSlip fixedProfile \
        fixedValue flowRateInletVelocity flowRateOutletVelocity fluxCorrectedVelocity freestream \
        freestreamVelocity inletOutlet interstitialInletVelocity mapped mappedField \
        mappedFixedInternalValue mappedFixedPushedInternalValue mappedFlowRate mappedVelocityFlux \
        matchedFlowRateOutletVelocity mixed movingWallVelocity noSlip nonuniformTransformCyclic \
        outletInlet outletMappedUniformInlet outletPhaseMeanVelocity partialSlip \
        pressureDirectedInletOutletVelocity pressureDirectedInletVelocity \
        pressureInletOutletParSlipVelocity pressureInletOutletVelocity pressureInletUniformVelocity \
        pressureInletVelocity pressureNormalInletOutletVelocity pressurePIDControlInletVelocity \
        processor processorCyclic rotatingPressureInletOutletVelocity rotatingWallVelocity \
        scaledFixedValue sliced slip supersonicFreestream surfaceNormalFixedValue swirlFanVelocity \
        swirlFlowRateInletVelocity swirlInletVelocity symmetry symmetryPlane \
        timeVaryingMappedFixedValue translatingWallVelocity turbulentDFSEMInlet \
        turbulentDigitalFilterInlet turbulentInlet uniformFixedGradient uniformFixedValue \
        uniformInletOutlet uniformJump uniformJumpAMI uniformNormalFixedValue \
        variableHeightFlowRateInletVelocity waveTransmissive wedge zeroGradient";
    const SCALARS: &str = "advective calculated codedFixedValue codedMixed cyclic cyclicACMI cyclicAMI \
        cyclicSlip directionMixed empty exprFixedValue exprMixed extrapolatedCalculated fan \
        fanPressure fixedFluxExtrapolatedPressure fixedFluxPressure fixedGradient fixedInternalValue \
        fixedJump fixedJumpAMI fixedMean fixedMeanOutletInlet fixedPressureCompressibleDensity \
        fixedProfile fixedValue freestream freestreamPressure inletOutlet \
        inletOutletTotalTemperature interfaceCompression mapped mappedField mappedFixedInternalValue \
        mappedFixedPushedInternalValue mixed nonuniformTransformCyclic outletInlet \
        outletMappedUniformInlet partialSlip phaseHydrostaticPressure plenumPressure prghPressure \
        prghTotalHydrostaticPressure prghTotalPressure processor processorCyclic \
        rotatingTotalPressure scaledFixedValue sliced slip symmetry symmetryPlane syringePressure \
        timeVaryingMappedFixedValue totalPressure totalTemperature turbulentInlet \
        turbulentIntensityKineticEnergyInlet uniformDensityHydrostaticPressure uniformFixedGradient \
        uniformFixedValue uniformInletOutlet uniformJump uniformJumpAMI uniformTotalPressure \
        variableHeightFlowRate waveSurfacePressure waveTransmissive wedge zeroGradient";

    #[test]
    fn every_condition_of_openfoam_is_done_or_refused_by_name() {
        assert_eq!((VECTORS.split(' ').count(), SCALARS.split(' ').count()), (88, 71));
        for (names, vector) in [(VECTORS, true), (SCALARS, false)] {
            for name in names.split(' ') {
                let done = ALL.iter().any(|e| {
                    e.name == name && if vector { e.vector.is_some() } else { e.scalar.is_some() }
                });
                assert!(done != refused(name).is_some(), "{name}: done {done}");
            }
        }
    }

    #[test]
    fn a_refusal_says_why_and_what_to_write() {
        let said =
            |name: &str| mistakes::<f64>(&format!("type {name}; code #{{ x #}};")).to_string();
        let text = said("codedFixedValue");
        assert!(text.contains("`codedFixedValue` is not supported"), "{text}");
        assert!(text.contains("compiled") && text.contains("uniformFixedValue"), "{text}");
        assert!(said("nutkRoughWallFunction").contains("turbulence"));
        assert!(said("symmetry").contains("give the patch the type"));
    }
}

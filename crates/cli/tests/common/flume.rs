//! The flume's files.

pub(super) const FLUME: &[(&str, &str)] = &[
    (
        "system/blockMeshDict",
        "
FoamFile { version 2.0; format ascii; class dictionary; object blockMeshDict; }
vertices
(
    (0 0 0) (4 0 0) (4 0.1 0) (0 0.1 0)
    (0 0 0.6) (4 0 0.6) (4 0.1 0.6) (0 0.1 0.6)
);
blocks ( hex (0 1 2 3 4 5 6 7) (80 1 30) simpleGrading (1 1 1) );
boundary
(
    inlet  { type patch; faces ((0 4 7 3)); }
    outlet { type patch; faces ((1 5 6 2)); }
    ground { type wall;  faces ((0 1 2 3)); }
    top    { type patch; faces ((4 5 6 7)); }
    sides  { type empty; faces ((0 1 5 4) (3 2 6 7)); }
);
",
    ),
    (
        "system/controlDict",
        "
FoamFile { version 2.0; format ascii; class dictionary; object controlDict; }
application     interFoam;
startFrom       latestTime;
endTime         4.5;
deltaT          0.005;
writeControl    adjustable;
writeInterval   0.1875;
writePrecision  12;
adjustTimeStep  yes;
maxCo           0.5;
maxAlphaCo      0.5;
maxDeltaT       0.02;
",
    ),
    (
        "system/setFieldsDict",
        "
FoamFile { version 2.0; format ascii; class dictionary; object setFieldsDict; }
defaultFieldValues ( volScalarFieldValue alpha.water 0 );
regions ( boxToCell { box (0 0 0) (4 1 0.4); fieldValues ( volScalarFieldValue alpha.water 1 ); } );
",
    ),
    (
        "system/fvSchemes",
        "
FoamFile { version 2.0; format ascii; class dictionary; object fvSchemes; }
ddtSchemes { default Euler; }
gradSchemes { default Gauss linear; }
divSchemes
{
    div(rhoPhi,U)    Gauss linearUpwind grad(U);
    div(phi,alpha)   Gauss vanLeer;
    div(phirb,alpha) Gauss linear;
}
laplacianSchemes { default Gauss linear corrected; }
",
    ),
    (
        "system/fvSolution",
        "
FoamFile { version 2.0; format ascii; class dictionary; object fvSolution; }
solvers
{
    \"alpha.water.*\" { nAlphaCorr 1; nAlphaSubCycles 1; cAlpha 1; }
    p_rgh      { solver PCG; preconditioner DIC; tolerance 1e-8; relTol 0.01; }
    p_rghFinal { $p_rgh; relTol 0; }
    U          { solver PBiCGStab; preconditioner DILU; tolerance 1e-8; relTol 0; }
}
PIMPLE { momentumPredictor no; nCorrectors 2; nNonOrthogonalCorrectors 0; }
",
    ),
    (
        "constant/g",
        "
FoamFile { version 2.0; format ascii; class uniformDimensionedVectorField; object g; }
dimensions      [0 1 -2 0 0 0 0];
value           (0 0 -9.81);
",
    ),
    (
        "constant/transportProperties",
        "
FoamFile { version 2.0; format ascii; class dictionary; object transportProperties; }
phases (water air);
water { transportModel Newtonian; nu 1e-06; rho 1000; }
air   { transportModel Newtonian; nu 1.48e-05; rho 1; }
sigma           0;
",
    ),
    (
        "constant/waveProperties",
        "
FoamFile { version 2.0; format ascii; class dictionary; object waveProperties; }
inlet
{
    alpha           alpha.water;
    waveModel       StokesI;
    nPaddle         1;
    waveHeight      0.04;
    waveAngle       0;
    wavePeriod      1.5;
    rampTime        1.5;
    activeAbsorption yes;
}
outlet
{
    alpha           alpha.water;
    waveModel       shallowWaterAbsorption;
    nPaddle         1;
}
",
    ),
    (
        "0.orig/U",
        "
FoamFile { version 2.0; format ascii; class volVectorField; object U; }
dimensions      [0 1 -1 0 0 0 0];
internalField   uniform (0 0 0);
boundaryField
{
    inlet  { type waveVelocity; value uniform (0 0 0); }
    outlet { type waveVelocity; value uniform (0 0 0); }
    ground { type noSlip; }
    top    { type pressureInletOutletVelocity; value uniform (0 0 0); }
    sides  { type empty; }
}
",
    ),
    (
        "0.orig/alpha.water",
        "
FoamFile { version 2.0; format ascii; class volScalarField; object alpha.water; }
dimensions      [0 0 0 0 0 0 0];
internalField   uniform 0;
boundaryField
{
    inlet  { type waveAlpha; value uniform 0; }
    outlet { type zeroGradient; }
    ground { type zeroGradient; }
    top    { type inletOutlet; inletValue uniform 0; value uniform 0; }
    sides  { type empty; }
}
",
    ),
    (
        "0.orig/p_rgh",
        "
FoamFile { version 2.0; format ascii; class volScalarField; object p_rgh; }
dimensions      [1 -1 -2 0 0 0 0];
internalField   uniform 0;
boundaryField
{
    \"(inlet|outlet|ground)\" { type fixedFluxPressure; value uniform 0; }
    top    { type totalPressure; p0 uniform 0; }
    sides  { type empty; }
}
",
    ),
];

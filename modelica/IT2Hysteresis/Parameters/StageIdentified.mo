within IT2Hysteresis.Parameters;
record StageIdentified "Parameter set identified from the demo's record"
  extends IT2Hysteresis.Parameters.Base(
    sampleTime=0.0001,
    initialDisplacement=-2.775782488590551e-07,
    voltageMin=0.0,
    voltageMax=104.08202514567344,
    displacementMin=-1.5300903320312503e-06,
    displacementMax=1.685443115234375e-05,
    delayTime=0.0,
    slewRate=0.0,
    saturationMinimum=0.0,
    saturationMaximum=0.0,
    lagTimeConstant=0.0,
    loadCompliance=0.0,
    resonanceFrequency=0.0,
    resonanceDamping=0.0,
    resonanceSamplingZero=0.0,
    resonanceSamplingDelay=0.0,
    driftTemperatureCoefficient=0.0,
    driftRate=0.0,
    nonlinearityQuadratic=0.0,
    nonlinearityCubic=0.0,
    nonlinearityQuartic=0.0,
    humAmplitude=0.0,
    humFrequency=0.0,
    humPhase=0.0,
    initialDemagnetisation=0.0,
    initialExcursion=0.0,
    initialCreep=0.0,
    nonlinearityMinimum=-1.5300903320312503e-06,
    nonlinearityMaximum=1.685443115234375e-05,
    displacementZero=5.670856708181477e-07,
    nonlinearityQuintic=0.0,
    nonlinearitySextic=0.0,
    initialCreepAge=0.0,
    ruleSigmaLower={7.660217285156254e-07, 8.03061536777212e-07, 4.577661836890067e-06},
    ruleSigmaUpper={1.7152121490037666e-05, 4.877178220417038e-06, 1.49394812882482e-05},
    ruleCentre={3.805723345457027e-08, 7.249923438772499e-06, 8.328383570658194e-06},
    ruleQ1={1.4655866614167046, 1.7041697717695015, 0.17577615293599544},
    ruleQ2={3.412945146789629e-08, 3.0155836006068815e-08, 2.467851908349339e-08},
    ruleQ3={-3.2472543156978897e-07, -6.400217441793664e-06, 2.6771072369684074e-06});
  annotation (
    defaultComponentPrefixes="parameter",
    Documentation(info="<html>
<p>
The parameter set <em>identified from the demo&#x27;s record</em>, written by it2hys. Numbers are in SI units.
</p>
</html>",
      revisions="<html>
<p>
Written for version 0.1.0 of the library.
</p>
</html>"));
end StageIdentified;

within IT2Hysteresis.Parameters;
record StageIdentified "Parameter set identified from the demo's record"
  extends IT2Hysteresis.Parameters.Base(
    sampleTime=0.0001,
    initialDisplacement=-3.4673751450151055e-07,
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
    displacementZero=6.514979832320087e-07,
    nonlinearityQuintic=0.0,
    nonlinearitySextic=0.0,
    ruleSigmaLower={7.660217285156254e-07, 7.660217285156254e-07, 3.032952159262615e-06},
    ruleSigmaUpper={1.6122954538046948e-05, 1.0824491763234e-05, 1.4576167923506122e-05},
    ruleCentre={-1.0716442869255808e-06, 7.253215266706479e-06, 1.9826908699312773e-05},
    ruleQ1={0.0782855607996372, 1.4522054742063153, 0.06960460353768365},
    ruleQ2={2.851208485989168e-08, 2.8944757303270403e-08, 2.7542599050248243e-08},
    ruleQ3={-1.3558499555266654e-06, -4.533734448976868e-06, 1.3959997031615283e-05});
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

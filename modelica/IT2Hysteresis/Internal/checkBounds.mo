within IT2Hysteresis.Internal;
function checkBounds "Stops with the reason where a parameter is beyond its bounds"
  extends Modelica.Icons.Function;
  input String name "Block that messages begin with";
  input Real values[:] "All parameters, of Values";
  input Integer ruleCount "Number of rules L";
  input Integer playCount "Number of play operators in front of the core; 0 for none";
  input Integer creepCount "Number of creep terms; 0 for none";
algorithm
  assert(values[1] >= 1e-09 and values[1] <= 1000.0,
    name + ": sampleTime is " + String(values[1], significantDigits=6)
    + "; it must be 1e-09 to 1000.");
  assert(values[2] >= -0.1 and values[2] <= 0.1,
    name + ": initialDisplacement is " + String(values[2], significantDigits=6)
    + "; it must be -0.1 to 0.1.");
  assert(values[3] >= -2000.0 and values[3] <= 2000.0,
    name + ": voltageMin is " + String(values[3], significantDigits=6)
    + "; it must be -2000 to 2000.");
  assert(values[4] >= -2000.0 and values[4] <= 2000.0,
    name + ": voltageMax is " + String(values[4], significantDigits=6)
    + "; it must be -2000 to 2000.");
  assert(values[5] >= -0.1 and values[5] <= 0.1,
    name + ": displacementMin is " + String(values[5], significantDigits=6)
    + "; it must be -0.1 to 0.1.");
  assert(values[6] >= -0.1 and values[6] <= 0.1,
    name + ": displacementMax is " + String(values[6], significantDigits=6)
    + "; it must be -0.1 to 0.1.");
  assert(values[7] >= 1 and values[7] <= 16,
    name + ": ruleCount is " + String(values[7], significantDigits=6)
    + "; it must be 1 to 16.");
  assert(abs(values[8 + 1*ruleCount] - ruleCount) < 0.5,
    name + ": ruleSigmaUpper has " + String(values[8 + 1*ruleCount], significantDigits=6)
    + " elements and ruleSigmaLower has " + String(ruleCount)
    + "; they must have the same number.");
  assert(abs(values[9 + 2*ruleCount] - ruleCount) < 0.5,
    name + ": ruleCentre has " + String(values[9 + 2*ruleCount], significantDigits=6)
    + " elements and ruleSigmaLower has " + String(ruleCount)
    + "; they must have the same number.");
  assert(abs(values[10 + 3*ruleCount] - ruleCount) < 0.5,
    name + ": ruleQ1 has " + String(values[10 + 3*ruleCount], significantDigits=6)
    + " elements and ruleSigmaLower has " + String(ruleCount)
    + "; they must have the same number.");
  assert(abs(values[11 + 4*ruleCount] - ruleCount) < 0.5,
    name + ": ruleQ2 has " + String(values[11 + 4*ruleCount], significantDigits=6)
    + " elements and ruleSigmaLower has " + String(ruleCount)
    + "; they must have the same number.");
  assert(abs(values[12 + 5*ruleCount] - ruleCount) < 0.5,
    name + ": ruleQ3 has " + String(values[12 + 5*ruleCount], significantDigits=6)
    + " elements and ruleSigmaLower has " + String(ruleCount)
    + "; they must have the same number.");
  for j in 1:ruleCount loop
    assert(values[7 + j] >= 1e-12 and values[7 + j] <= 1.0,
      name + ": ruleSigmaLower[" + String(j) + "] is " + String(values[7 + j], significantDigits=6)
      + "; it must be 1e-12 to 1.");
    assert(values[8 + 1*ruleCount + j] >= 1e-12 and values[8 + 1*ruleCount + j] <= 1.0,
      name + ": ruleSigmaUpper[" + String(j) + "] is " + String(values[8 + 1*ruleCount + j], significantDigits=6)
      + "; it must be 1e-12 to 1.");
    assert(values[9 + 2*ruleCount + j] >= -0.1 and values[9 + 2*ruleCount + j] <= 0.1,
      name + ": ruleCentre[" + String(j) + "] is " + String(values[9 + 2*ruleCount + j], significantDigits=6)
      + "; it must be -0.1 to 0.1.");
    assert(values[10 + 3*ruleCount + j] >= -10.0 and values[10 + 3*ruleCount + j] <= 10.0,
      name + ": ruleQ1[" + String(j) + "] is " + String(values[10 + 3*ruleCount + j], significantDigits=6)
      + "; it must be -10 to 10.");
    assert(values[11 + 4*ruleCount + j] >= -0.1 and values[11 + 4*ruleCount + j] <= 0.1,
      name + ": ruleQ2[" + String(j) + "] is " + String(values[11 + 4*ruleCount + j], significantDigits=6)
      + "; it must be -0.1 to 0.1.");
    assert(values[12 + 5*ruleCount + j] >= -0.1 and values[12 + 5*ruleCount + j] <= 0.1,
      name + ": ruleQ3[" + String(j) + "] is " + String(values[12 + 5*ruleCount + j], significantDigits=6)
      + "; it must be -0.1 to 0.1.");
  end for;
  assert(values[13 + 6*ruleCount] >= 0 and values[13 + 6*ruleCount] <= 32,
    name + ": playCount is " + String(values[13 + 6*ruleCount], significantDigits=6)
    + "; it must be 0 to 32.");
  assert(abs(values[14 + 6*ruleCount + 1*playCount] - playCount) < 0.5,
    name + ": playWeight has " + String(values[14 + 6*ruleCount + 1*playCount], significantDigits=6)
    + " elements and playThreshold has " + String(playCount)
    + "; they must have the same number.");
  for j in 1:playCount loop
    assert(values[13 + 6*ruleCount + j] >= 0.0 and values[13 + 6*ruleCount + j] <= 4000.0,
      name + ": playThreshold[" + String(j) + "] is " + String(values[13 + 6*ruleCount + j], significantDigits=6)
      + "; it must be 0 to 4000.");
    assert(values[14 + 6*ruleCount + 1*playCount + j] >= -10.0 and values[14 + 6*ruleCount + 1*playCount + j] <= 10.0,
      name + ": playWeight[" + String(j) + "] is " + String(values[14 + 6*ruleCount + 1*playCount + j], significantDigits=6)
      + "; it must be -10 to 10.");
  end for;
  assert(values[15 + 6*ruleCount + 2*playCount] >= 0 and values[15 + 6*ruleCount + 2*playCount] <= 16,
    name + ": creepCount is " + String(values[15 + 6*ruleCount + 2*playCount], significantDigits=6)
    + "; it must be 0 to 16.");
  assert(abs(values[16 + 6*ruleCount + 2*playCount + 1*creepCount] - creepCount) < 0.5,
    name + ": creepTimeConstant has " + String(values[16 + 6*ruleCount + 2*playCount + 1*creepCount], significantDigits=6)
    + " elements and creepGain has " + String(creepCount)
    + "; they must have the same number.");
  for j in 1:creepCount loop
    assert(values[15 + 6*ruleCount + 2*playCount + j] >= -10.0 and values[15 + 6*ruleCount + 2*playCount + j] <= 10.0,
      name + ": creepGain[" + String(j) + "] is " + String(values[15 + 6*ruleCount + 2*playCount + j], significantDigits=6)
      + "; it must be -10 to 10.");
    assert(values[16 + 6*ruleCount + 2*playCount + 1*creepCount + j] >= 0.0 and values[16 + 6*ruleCount + 2*playCount + 1*creepCount + j] <= 1000000.0,
      name + ": creepTimeConstant[" + String(j) + "] is " + String(values[16 + 6*ruleCount + 2*playCount + 1*creepCount + j], significantDigits=6)
      + "; it must be 0 to 1e+06.");
  end for;
  assert(values[17 + 6*ruleCount + 2*playCount + 2*creepCount] >= 0.0 and values[17 + 6*ruleCount + 2*playCount + 2*creepCount] <= 1000000.0,
    name + ": delayTime is " + String(values[17 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be 0 to 1e+06.");
  assert(values[18 + 6*ruleCount + 2*playCount + 2*creepCount] >= 0.0 and values[18 + 6*ruleCount + 2*playCount + 2*creepCount] <= 1000000000000.0,
    name + ": slewRate is " + String(values[18 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be 0 to 1e+12.");
  assert(values[19 + 6*ruleCount + 2*playCount + 2*creepCount] >= -2000.0 and values[19 + 6*ruleCount + 2*playCount + 2*creepCount] <= 2000.0,
    name + ": saturationMinimum is " + String(values[19 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -2000 to 2000.");
  assert(values[20 + 6*ruleCount + 2*playCount + 2*creepCount] >= -2000.0 and values[20 + 6*ruleCount + 2*playCount + 2*creepCount] <= 2000.0,
    name + ": saturationMaximum is " + String(values[20 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -2000 to 2000.");
  assert(values[21 + 6*ruleCount + 2*playCount + 2*creepCount] >= 0.0 and values[21 + 6*ruleCount + 2*playCount + 2*creepCount] <= 1000000.0,
    name + ": lagTimeConstant is " + String(values[21 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be 0 to 1e+06.");
  assert(values[22 + 6*ruleCount + 2*playCount + 2*creepCount] >= 0.0 and values[22 + 6*ruleCount + 2*playCount + 2*creepCount] <= 1.0,
    name + ": loadCompliance is " + String(values[22 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be 0 to 1.");
  assert(values[23 + 6*ruleCount + 2*playCount + 2*creepCount] >= 0.0 and values[23 + 6*ruleCount + 2*playCount + 2*creepCount] <= 1000000000.0,
    name + ": resonanceFrequency is " + String(values[23 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be 0 to 1e+09.");
  assert(values[24 + 6*ruleCount + 2*playCount + 2*creepCount] >= 0.0 and values[24 + 6*ruleCount + 2*playCount + 2*creepCount] <= 1.0,
    name + ": resonanceDamping is " + String(values[24 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be 0 to 1.");
  assert(values[25 + 6*ruleCount + 2*playCount + 2*creepCount] >= -0.95 and values[25 + 6*ruleCount + 2*playCount + 2*creepCount] <= 0.0,
    name + ": resonanceSamplingZero is " + String(values[25 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -0.95 to 0.");
  assert(values[26 + 6*ruleCount + 2*playCount + 2*creepCount] >= 0.0 and values[26 + 6*ruleCount + 2*playCount + 2*creepCount] <= 1000000.0,
    name + ": resonanceSamplingDelay is " + String(values[26 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be 0 to 1e+06.");
  assert(values[27 + 6*ruleCount + 2*playCount + 2*creepCount] >= -0.001 and values[27 + 6*ruleCount + 2*playCount + 2*creepCount] <= 0.001,
    name + ": driftTemperatureCoefficient is " + String(values[27 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -0.001 to 0.001.");
  assert(values[28 + 6*ruleCount + 2*playCount + 2*creepCount] >= -0.001 and values[28 + 6*ruleCount + 2*playCount + 2*creepCount] <= 0.001,
    name + ": driftRate is " + String(values[28 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -0.001 to 0.001.");
  assert(values[29 + 6*ruleCount + 2*playCount + 2*creepCount] >= -0.1 and values[29 + 6*ruleCount + 2*playCount + 2*creepCount] <= 0.1,
    name + ": nonlinearityQuadratic is " + String(values[29 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -0.1 to 0.1.");
  assert(values[30 + 6*ruleCount + 2*playCount + 2*creepCount] >= -0.1 and values[30 + 6*ruleCount + 2*playCount + 2*creepCount] <= 0.1,
    name + ": nonlinearityCubic is " + String(values[30 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -0.1 to 0.1.");
  assert(values[31 + 6*ruleCount + 2*playCount + 2*creepCount] >= -0.1 and values[31 + 6*ruleCount + 2*playCount + 2*creepCount] <= 0.1,
    name + ": nonlinearityQuartic is " + String(values[31 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -0.1 to 0.1.");
  assert(values[32 + 6*ruleCount + 2*playCount + 2*creepCount] >= -0.1 and values[32 + 6*ruleCount + 2*playCount + 2*creepCount] <= 0.1,
    name + ": humAmplitude is " + String(values[32 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -0.1 to 0.1.");
  assert(values[33 + 6*ruleCount + 2*playCount + 2*creepCount] >= 0.0 and values[33 + 6*ruleCount + 2*playCount + 2*creepCount] <= 1000000000.0,
    name + ": humFrequency is " + String(values[33 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be 0 to 1e+09.");
  assert(values[34 + 6*ruleCount + 2*playCount + 2*creepCount] >= -100.0 and values[34 + 6*ruleCount + 2*playCount + 2*creepCount] <= 100.0,
    name + ": humPhase is " + String(values[34 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -100 to 100.");
  assert(values[35 + 6*ruleCount + 2*playCount + 2*creepCount] >= -2000.0 and values[35 + 6*ruleCount + 2*playCount + 2*creepCount] <= 2000.0,
    name + ": initialDemagnetisation is " + String(values[35 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -2000 to 2000.");
  assert(values[36 + 6*ruleCount + 2*playCount + 2*creepCount] >= -2000.0 and values[36 + 6*ruleCount + 2*playCount + 2*creepCount] <= 2000.0,
    name + ": initialExcursion is " + String(values[36 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -2000 to 2000.");
  assert(values[37 + 6*ruleCount + 2*playCount + 2*creepCount] >= -0.1 and values[37 + 6*ruleCount + 2*playCount + 2*creepCount] <= 0.1,
    name + ": initialCreep is " + String(values[37 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -0.1 to 0.1.");
  assert(values[38 + 6*ruleCount + 2*playCount + 2*creepCount] >= -0.1 and values[38 + 6*ruleCount + 2*playCount + 2*creepCount] <= 0.1,
    name + ": nonlinearityMinimum is " + String(values[38 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -0.1 to 0.1.");
  assert(values[39 + 6*ruleCount + 2*playCount + 2*creepCount] >= -0.1 and values[39 + 6*ruleCount + 2*playCount + 2*creepCount] <= 0.1,
    name + ": nonlinearityMaximum is " + String(values[39 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -0.1 to 0.1.");
  assert(values[40 + 6*ruleCount + 2*playCount + 2*creepCount] >= -0.1 and values[40 + 6*ruleCount + 2*playCount + 2*creepCount] <= 0.1,
    name + ": displacementZero is " + String(values[40 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -0.1 to 0.1.");
  assert(values[41 + 6*ruleCount + 2*playCount + 2*creepCount] >= -0.1 and values[41 + 6*ruleCount + 2*playCount + 2*creepCount] <= 0.1,
    name + ": nonlinearityQuintic is " + String(values[41 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -0.1 to 0.1.");
  assert(values[42 + 6*ruleCount + 2*playCount + 2*creepCount] >= -0.1 and values[42 + 6*ruleCount + 2*playCount + 2*creepCount] <= 0.1,
    name + ": nonlinearitySextic is " + String(values[42 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be -0.1 to 0.1.");
  assert(values[43 + 6*ruleCount + 2*playCount + 2*creepCount] >= 0.0 and values[43 + 6*ruleCount + 2*playCount + 2*creepCount] <= 1000000.0,
    name + ": initialCreepAge is " + String(values[43 + 6*ruleCount + 2*playCount + 2*creepCount], significantDigits=6)
    + "; it must be 0 to 1e+06.");
  annotation (
    Documentation(info="<html>
<p>
The vector is <code>checked</code> of <a href=\"modelica://IT2Hysteresis.Internal.Values\">Values</a>. Bounds and words are
those of the FMUs.
</p>
</html>",
      revisions="<html>
<p>
Written for version 0.1.0 of the library.
</p>
</html>"));
end checkBounds;

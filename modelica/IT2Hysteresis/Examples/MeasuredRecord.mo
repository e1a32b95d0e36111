within IT2Hysteresis.Examples;
model MeasuredRecord "A measured record beside the model, before and after a diagnosis"
  extends Modelica.Icons.Example;
  Modelica.Blocks.Sources.CombiTimeTable measurement(
    tableOnFile=true,
    tableName="record",
    fileName=Modelica.Utilities.Files.loadResource("modelica://IT2Hysteresis/Resources/Data/sine_20Hz.txt"),
    columns={2,3},
    smoothness=Modelica.Blocks.Types.Smoothness.LinearSegments) "Record: voltage and displacement"
    annotation (Placement(transformation(extent={{-90,-10},{-70,10}})));
  IT2Hysteresis.Blocks.PureModelica.Plant before(
    redeclare record Stage = IT2Hysteresis.Parameters.StageIdentified,
    parameters(voltageMax=105),
    initialDisplacement=0) "The paper's model, identified from another record"
    annotation (Placement(transformation(extent={{-30,20},{-10,40}})));
  IT2Hysteresis.Blocks.PureModelica.Plant after(
    redeclare record Stage = IT2Hysteresis.Parameters.StageDiagnosed,
    parameters(voltageMax=105),
    initialDisplacement=0) "The same with what a diagnosis has found"
    annotation (Placement(transformation(extent={{-30,-40},{-10,-20}})));
  Modelica.Blocks.Math.Feedback errorBefore "Model less measurement"
    annotation (Placement(transformation(extent={{30,20},{50,40}})));
  Modelica.Blocks.Math.Feedback errorAfter "Model less measurement"
    annotation (Placement(transformation(extent={{30,-40},{50,-20}})));
equation
  connect(measurement.y[1], before.voltage)
    annotation (Line(points={{-69,0},{-50,0},{-50,30},{-32,30}}, color={0,0,127}));
  connect(measurement.y[1], after.voltage)
    annotation (Line(points={{-69,0},{-50,0},{-50,-30},{-32,-30}}, color={0,0,127}));
  connect(before.displacement, errorBefore.u1)
    annotation (Line(points={{-9,30},{32,30}}, color={0,0,127}));
  connect(after.displacement, errorAfter.u1)
    annotation (Line(points={{-9,-30},{32,-30}}, color={0,0,127}));
  connect(measurement.y[2], errorBefore.u2)
    annotation (Line(points={{-69,0},{40,0},{40,22}}, color={0,0,127}));
  connect(measurement.y[2], errorAfter.u2)
    annotation (Line(points={{-69,0},{-50,0},{-50,-60},{40,-60},{40,-38}}, color={0,0,127}));
  annotation (
    experiment(StopTime=0.1, Interval=1e-4, Tolerance=1e-6),
    Documentation(info="<html>
<p>
A record of voltage and displacement is read from a file and stands beside two models that get its voltage alone. Both were identified
from another record of the same stage, which is the simulated one of <code>it2hys run demo</code>: the paper's model, by
<code>it2hys identify</code>, and the same with play operators and creep, by <code>it2hys diagnose</code>. The records
<a href=\"modelica://IT2Hysteresis.Parameters.StageIdentified\">StageIdentified</a> and
<a href=\"modelica://IT2Hysteresis.Parameters.StageDiagnosed\">StageDiagnosed</a> hold them, in the form that <code>it2hys package --modelica</code> writes. What was before the record is unknown, so that the first
period counts little; in the second the error falls from 0.31 to 0.07 &#181;m rms. The record goes to 105 V, 1 V farther than the one
that was fitted; <code>voltageMax</code> is modified in place, so that there is no warning of it.
</p>
<p>
For a record of yours, write time in s, voltage in V and displacement in m as the table of a text file, name it in
<code>measurement.fileName</code>, and redeclare <code>Stage</code>.
</p>
<p>
<img src=\"modelica://IT2Hysteresis/Resources/Images/Examples/MeasuredRecord.png\" width=\"640\" alt=\"Errors of the model before and after a diagnosis, and the displacement, over time\"/>
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>",
      figures={
        Figure(
          title="Errors before and after",
          identifier="error",
          preferred=true,
          plots={
            Plot(curves={Curve(y=errorBefore.y, legend="Before"), Curve(y=errorAfter.y, legend="After")})}),
        Figure(
          title="Displacement",
          identifier="displacement",
          plots={
            Plot(curves={Curve(y=measurement.y[2], legend="Measured"), Curve(y=before.displacement, legend="Before"), Curve(y=after.displacement, legend="After")})})}));
end MeasuredRecord;

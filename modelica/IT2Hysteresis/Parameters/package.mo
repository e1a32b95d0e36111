within IT2Hysteresis;
package Parameters "Parameter records"
  extends Modelica.Icons.RecordsPackage;
  annotation (Documentation(info="<html>
<p>
A parameter set is a record that extends <a href=\"modelica://IT2Hysteresis.Parameters.Base\">Base</a>.
<a href=\"modelica://IT2Hysteresis.Parameters.Table1\">Table1</a> is the paper's. <code>it2hys package PARAMETERS.ssv --modelica -o DIR</code>
writes an identified set as such a record, a class of its own that stands beside the library.
</p>
<p>
<a href=\"modelica://IT2Hysteresis.Parameters.StageIdentified\">StageIdentified</a> and
<a href=\"modelica://IT2Hysteresis.Parameters.StageDiagnosed\">StageDiagnosed</a> are such sets, of the simulated stage of <code>it2hys run demo</code>.
</p>
<p>
Base and Table1 are generated from the table of variables that the FMUs are generated from; changes belong
there.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Parameters;

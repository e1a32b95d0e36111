within IT2Hysteresis;
package Blocks "Plant and inverse as input/output blocks"
  extends Modelica.Icons.Package;
  annotation (Documentation(info="<html>
<p>
The plant and its inverse, as the FMUs compute them, see
<a href=\"modelica://IT2Hysteresis.UsersGuide.ExternalCode\">External code</a>. <a href=\"modelica://IT2Hysteresis.Blocks.PureModelica\">PureModelica</a> holds their
realisations without external C code.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Blocks;

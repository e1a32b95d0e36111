within IT2Hysteresis;
package Components "Physical components around the plant"
  extends Modelica.Icons.Package;
  annotation (Documentation(info="<html>
<p>
What a mechatronic model needs around the <a href=\"modelica://IT2Hysteresis.Blocks\">blocks</a>: a piezo actuator with electrical
pins and translational flanges, the amplifier that drives it, the strain gauge that measures it and a sampled
controller. They connect to <code>Modelica.Electrical.Analog</code> and <code>Modelica.Mechanics.Translational</code>.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Components;

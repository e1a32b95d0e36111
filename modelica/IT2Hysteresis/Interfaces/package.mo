within IT2Hysteresis;
package Interfaces "Partial blocks"
  extends Modelica.Icons.InterfacesPackage;
  annotation (Documentation(info="<html>
<p>
What every realisation of the plant and of the inverse has in common: connectors, parameters and icon. Names are those
of the FMUs' variables.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Interfaces;

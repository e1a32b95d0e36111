within IT2Hysteresis.Functions.Effects;
function delayed "Delay: the voltage that was there some ticks ago"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Voltage u[:] "Voltages at the ticks before, u_{k-1}, u_{k-2}, ...";
  input Modelica.Units.SI.Voltage x "Voltage at this tick, u_k";
  input Integer ticks(min=0, max=size(u, 1) - 1) "Whole ticks of the delay, n";
  input Real fraction(unit="1", min=0, max=1) "Fraction of a tick beyond them";
  output Modelica.Units.SI.Voltage y "Delayed voltage";
protected
  Modelica.Units.SI.Voltage next=if ticks > 0 then u[max(ticks, 1)] else x "u_{k-n}";
algorithm
  y := next + fraction*(u[ticks + 1] - next);
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
y = Functions.Effects.<strong>delayed</strong>(u, x, ticks, fraction);
</pre>
<h4>Description</h4>
<p>
y<sub>k</sub> = u<sub>k-n</sub> + fraction (u<sub>k-n-1</sub> - u<sub>k-n</sub>): straight between ticks. There is no inverse; the
inverse block drives the chain behind the delay.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end delayed;

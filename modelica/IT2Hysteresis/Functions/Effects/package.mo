within IT2Hysteresis.Functions;
package Effects "The stages around the fuzzy system, one by one"
  extends Modelica.Icons.FunctionsPackage;
  annotation (Documentation(info="<html>
<p>
Every effect of the <a href=\"modelica://IT2Hysteresis.UsersGuide.Effects\">chain</a> as functions of its states at the tick before and
its input at this tick. x is a stage's input and y its output, k counts ticks. A function that is named after an effect
gives y of x, <code>...Inverse</code> gives x of y, <code>...States</code> the states that are handed to the next tick.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Effects;

//! Plots of a report as SVG: histograms and a curve. Each labels its own axes.

use svg::Document;
use svg::node::element::{Line, Polyline, Rectangle, Text};

/// Size of a plot \[px\].
const PLOT_SIZE_PX: [f64; 2] = [420.0, 240.0];
/// Margins for the labels of axes: left, right, top, bottom \[px\].
const MARGINS_PX: [f64; 4] = [48.0, 22.0, 14.0, 40.0];
/// Bars of a histogram.
const BINS: usize = 20;
const INK: &str = "#1b2430";
const FILL: &str = "#2f86c1";

/// Ranges of the data along both axes.
struct Axes {
    x: [f64; 2],
    y: [f64; 2],
}

impl Axes {
    fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let share = |value: f64, [low, high]: [f64; 2]| if high > low { (value - low) / (high - low) } else { 0.5 };
        let (width, height) =
            (PLOT_SIZE_PX[0] - MARGINS_PX[0] - MARGINS_PX[1], PLOT_SIZE_PX[1] - MARGINS_PX[2] - MARGINS_PX[3]);
        (MARGINS_PX[0] + width * share(x, self.x), PLOT_SIZE_PX[1] - MARGINS_PX[3] - height * share(y, self.y))
    }

    /// Draws the lines and numbers of both axes; `name` labels the horizontal one.
    fn frame(&self, name: &str, tell_x: &dyn Fn(f64) -> String, tell_y: &dyn Fn(f64) -> String) -> Document {
        let mut plot =
            Document::new().set("viewBox", (0, 0, PLOT_SIZE_PX[0] as u32, PLOT_SIZE_PX[1] as u32)).set("role", "img");
        for step in 0..=4 {
            let share = f64::from(step) / 4.0;
            let (x, y) = (self.x[0] + share * (self.x[1] - self.x[0]), self.y[0] + share * (self.y[1] - self.y[0]));
            let (left, level) = self.at(self.x[0], y);
            let (right, _) = self.at(self.x[1], y);
            let (column, bottom) = self.at(x, self.y[0]);
            plot = plot
                .add(
                    Line::new()
                        .set("x1", left)
                        .set("x2", right)
                        .set("y1", level)
                        .set("y2", level)
                        .set("stroke", "#d7dce3"),
                )
                .add(text(left - 6.0, level + 4.0, "end", &tell_y(y)))
                .add(text(column, bottom + 16.0, "middle", &tell_x(x)));
        }
        plot.add(text(PLOT_SIZE_PX[0] / 2.0, PLOT_SIZE_PX[1] - 6.0, "middle", name))
    }
}

fn text(x: f64, y: f64, anchor: &str, content: &str) -> Text {
    Text::new(content).set("x", x).set("y", y).set("text-anchor", anchor).set("font-size", 12).set("fill", INK)
}

/// Draws a histogram of `values` from `low` to `high`, or to their largest.
pub fn histogram(values: &[f64], low: f64, high: Option<f64>, name: &str) -> Document {
    let high = high.unwrap_or_else(|| values.iter().copied().filter(|x| x.is_finite()).fold(low + 1e-9, f64::max));
    let mut counts = [0usize; BINS];
    for value in values.iter().filter(|value| value.is_finite()) {
        let share = (value - low) / (high - low);
        counts[((share * BINS as f64) as usize).min(BINS - 1)] += 1;
    }
    let most = counts.iter().copied().max().unwrap_or(0).max(1) as f64;
    let axes = Axes { x: [low, high], y: [0.0, most] };
    let mut plot = axes.frame(name, &|x| format!("{x:.2}"), &|y| format!("{y:.0}"));
    for (bin, count) in counts.into_iter().enumerate() {
        let edge = |bin: usize| low + (high - low) * bin as f64 / BINS as f64;
        let ((left, top), (right, bottom)) = (axes.at(edge(bin), count as f64), axes.at(edge(bin + 1), 0.0));
        let bar = Rectangle::new().set("x", left + 0.5).set("y", top);
        plot = plot.add(bar.set("width", right - left - 1.0).set("height", bottom - top).set("fill", FILL));
    }
    plot
}

/// Draws shares over numbers of checks, on a logarithmic axis.
pub fn curve(points: &[(f64, f64)], name: &str) -> Document {
    let at = |checks: f64| checks.max(1.0).log10();
    let ends = points.iter().fold([f64::INFINITY, 0.0], |[low, high], (x, _)| [at(*x).min(low), at(*x).max(high)]);
    let axes = Axes { x: if ends[0].is_finite() { ends } else { [0.0, 1.0] }, y: [0.0, 1.0] };
    let mut plot = axes.frame(name, &|x| format!("{:.0}", 10f64.powf(x)), &|y| format!("{:.0} %", 100.0 * y));
    let places: Vec<(f64, f64)> = points.iter().map(|(x, y)| axes.at(at(*x), *y)).collect();
    let line: Vec<String> = places.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    plot = plot.add(
        Polyline::new().set("points", line.join(" ")).set("fill", "none").set("stroke", FILL).set("stroke-width", 2),
    );
    for (x, y) in places {
        plot = plot.add(
            Rectangle::new().set("x", x - 3.0).set("y", y - 3.0).set("width", 6).set("height", 6).set("fill", INK),
        );
    }
    plot
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_of_a_plot_is_one() {
        for values in [&[][..], &[0.0], &[0.5, 1.0, f64::NAN, f64::INFINITY, 0.5]] {
            let text =
                histogram(values, 0.0, None, "depth").to_string() + &histogram(values, 0.0, Some(1.0), "x").to_string();
            assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        }
        let text = curve(&[], "checks").to_string() + &curve(&[(10.0, 0.5), (100.0, 1.0)], "checks").to_string();
        assert!(!text.contains("NaN") && !text.contains("inf") && text.contains("50 %"), "{text}");
    }
}

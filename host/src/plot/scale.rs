//! Mapping of values to places on the page, with round tick values.

/// A closed range of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Lowest.
    pub low: f64,
    /// Highest.
    pub high: f64,
}

impl Span {
    /// The range of `values`, at least `least` wide and with `margin` of its width on both sides;
    /// around 0 when there are none.
    pub fn of(values: impl Iterator<Item = f64>, least: f64, margin: f64) -> Span {
        let (low, high) = values
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
        let (low, high) = if low > high { (0.0, 0.0) } else { (low, high) };
        let missing = (least - (high - low)).max(0.0) / 2.0;
        let (low, high) = (low - missing, high + missing);
        let room = (high - low) * margin;
        Span { low: low - room, high: high + room }
    }

    /// How wide it is.
    pub fn width(self) -> f64 {
        self.high - self.low
    }

    /// Round values in it, at most about `most`, and the digits to write them with.
    pub fn ticks(self, most: usize) -> (Vec<f64>, usize) {
        let rough = self.width() / most.max(1) as f64;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|factor| factor * power)
            .find(|step| *step >= rough)
            .unwrap_or(rough);
        let first = (self.low / step).ceil() as i64;
        let last = (self.high / step).floor() as i64;
        let digits = (-step.log10().floor()).max(0.0) as usize;
        ((first..=last).map(|n| n as f64 * step).collect(), digits)
    }
}

/// A value range on a stretch of the page.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// The values.
    pub span: Span,
    /// Where `span.low` lies.
    pub from: f64,
    /// Where `span.high` lies.
    pub to: f64,
}

impl Scale {
    /// Place of a value.
    pub fn at(&self, value: f64) -> f64 {
        self.from + (value - self.span.low) / self.span.width() * (self.to - self.from)
    }
}

#[cfg(test)]
mod tests {
    use super::{Scale, Span};

    #[test]
    fn ticks_are_round_and_inside() {
        let span = Span { low: -3.2, high: 41.0 };
        assert_eq!(span.ticks(6), (vec![0.0, 10.0, 20.0, 30.0, 40.0], 0));
        let span = Span { low: 0.0, high: 0.35 };
        let (ticks, digits) = span.ticks(4);
        assert_eq!((ticks.len(), digits), (4, 1));
    }

    #[test]
    fn a_point_and_nothing_get_a_width() {
        let span = Span::of([5.0].into_iter(), 2.0, 0.0);
        assert_eq!(span, Span { low: 4.0, high: 6.0 });
        let span = Span::of([f64::NAN].into_iter(), 2.0, 0.5);
        assert_eq!(span, Span { low: -2.0, high: 2.0 });
        let scale = Scale { span, from: 100.0, to: 0.0 };
        assert_eq!(scale.at(0.0), 50.0);
    }
}

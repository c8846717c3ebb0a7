//! What a laser, a pen or a dispenser drew, against the points that it must have passed.

use super::Judge;
use crate::list;

/// Judged within this where the expectation does not say, mm.
const WITHIN_MM: f64 = 0.1;

impl Judge<'_> {
    /// Every point of a file lies on a way that was drawn, within a tolerance.
    pub(super) fn engraved(&self) -> (String, String, bool, Vec<String>) {
        let within = self.number("within").unwrap_or(WITHIN_MM);
        let file = self.text("file");
        let points = match (self.files)(&file).and_then(|text| list::points(&file, &text)) {
            Ok(points) => points,
            Err(reason) => return ("engraving".to_owned(), reason, false, Vec::new()),
        };
        let ways = self.cell.drawn();
        let (mut missing, mut worst) = (0, 0.0f64);
        for point in &points {
            match ways.iter().filter_map(|way| off_way(*point, way)).min_by(f64::total_cmp) {
                Some(off) if off <= within => worst = worst.max(off),
                _ => missing += 1,
            }
        }
        let was = match missing {
            0 => format!("all, worst {worst:.3} mm"),
            _ => format!("{missing} missing"),
        };
        (format!("{} points within {within} mm", points.len()), was, missing == 0, Vec::new())
    }
}

/// Distance of a point from a way of straight pieces; `None` of an empty way.
fn off_way(point: [f64; 2], way: &[[f64; 2]]) -> Option<f64> {
    let off = |a: [f64; 2], b: [f64; 2]| {
        let (along, to) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
        let length = along[0] * along[0] + along[1] * along[1];
        let share = if length > 0.0 { (to[0] * along[0] + to[1] * along[1]) / length } else { 0.0 };
        let share = share.clamp(0.0, 1.0);
        (to[0] - share * along[0]).hypot(to[1] - share * along[1])
    };
    let first = way.first()?;
    let pieces = way.windows(2).map(|piece| off(piece[0], piece[1]));
    Some(pieces.fold(off(*first, *first), f64::min))
}

#[cfg(test)]
mod tests {
    use super::off_way;

    #[test]
    fn a_point_is_as_far_as_its_nearest_piece() {
        let way = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]];
        assert_eq!(off_way([5.0, 0.5], &way), Some(0.5));
        assert_eq!(off_way([13.0, 14.0], &way), Some(5.0));
        assert_eq!(off_way([-3.0, 4.0], &way[..1]), Some(5.0));
        assert_eq!(off_way([0.0, 0.0], &[]), None);
    }
}

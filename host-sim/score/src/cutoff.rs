//! Order and cut-off of the set distances.

use crate::assignment::assign;

/// Order p and cut-off c of a set distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cutoff {
    order: f64,
    distance: f64,
}

impl Cutoff {
    /// Order p ≥ 1 and cut-off c > 0 (in the unit of the points, m for maps), both finite.
    ///
    /// # Panics
    ///
    /// If they are not.
    pub const fn new(order: f64, distance: f64) -> Self {
        assert!(order >= 1.0 && order < f64::INFINITY, "the order is finite and at least 1");
        assert!(distance > 0.0 && distance < f64::INFINITY, "the cut-off is finite and more than 0");
        Self { order, distance }
    }

    /// Order p.
    pub const fn order(&self) -> f64 {
        self.order
    }

    /// Cut-off c, in the unit of the points.
    pub const fn distance(&self) -> f64 {
        self.distance
    }

    /// Distance of two points, cut off at c (3.30). For NaN it is c.
    ///
    /// # Panics
    ///
    /// If the points differ in dimension.
    pub(super) fn between(&self, a: &[f64], b: &[f64]) -> f64 {
        assert_eq!(a.len(), b.len(), "points of one dimension");
        let d = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        if d < self.distance { d } else { self.distance }
    }

    /// dᵖ. The usual orders are computed without a power function, whose last bit differs between machines.
    pub(super) fn power(&self, d: f64) -> f64 {
        if self.order == 1.0 {
            d
        } else if self.order == 2.0 {
            d * d
        } else {
            libm::pow(d, self.order)
        }
    }

    /// The p-th root of a sum.
    pub(super) fn root(&self, x: f64) -> f64 {
        if self.order == 1.0 {
            x
        } else if self.order == 2.0 {
            x.sqrt()
        } else {
            libm::pow(x, 1.0 / self.order)
        }
    }

    /// Cut-off distances of the pairs of the assignment with the least sum of their p-th powers.
    pub(super) fn matched<X: AsRef<[f64]>, Y: AsRef<[f64]>>(&self, x: &[X], y: &[Y]) -> Vec<f64> {
        let mut distances: Vec<f64> = self.pairs(x, y).into_iter().map(|(_, _, distance)| distance).collect();
        distances.resize(x.len().min(y.len()), self.distance);
        distances
    }

    /// The pairs of this assignment with a distance below c: indices in `x` and `y` and distance, by ascending index in `x`.
    ///
    /// All pairs with a distance of c or more cost the same, so that only near pairs matter. Groups of points without near pairs
    /// between them are solved separately, which is exact and turns one large problem into many small ones.
    pub fn pairs<X: AsRef<[f64]>, Y: AsRef<[f64]>>(&self, x: &[X], y: &[Y]) -> Vec<(usize, usize, f64)> {
        let distances: Vec<f64> =
            x.iter().flat_map(|a| y.iter().map(|b| self.between(a.as_ref(), b.as_ref()))).collect();
        let mut pairs = Vec::new();
        for (rows, columns) in groups(x.len(), y.len(), |row, column| distances[row * y.len() + column] < self.distance)
        {
            let distance = |row: usize, column: usize| distances[rows[row] * y.len() + columns[column]];
            // In units of c, so that high powers do not overflow.
            let cost = |row: usize, column: usize| self.power(distance(row, column) / self.distance);
            let costs: Vec<f64> = (0..rows.len())
                .flat_map(|row| (0..columns.len()).map(move |column| (row, column)))
                .map(|(row, column)| cost(row, column))
                .collect();
            let chosen = assign(&costs, rows.len(), columns.len()).into_iter();
            pairs.extend(chosen.map(|(row, column)| (rows[row], columns[column], distance(row, column))));
        }
        pairs.retain(|&(_, _, distance)| distance < self.distance);
        pairs.sort_unstable_by_key(|&(row, _, _)| row);
        pairs
    }
}

/// Groups of rows and columns that are connected by `near`, both ascending; rows and columns that are near nothing are left out.
fn groups(rows: usize, columns: usize, near: impl Fn(usize, usize) -> bool) -> Vec<(Vec<usize>, Vec<usize>)> {
    let mut taken = vec![false; columns];
    let mut grouped = vec![false; rows];
    let mut groups = Vec::new();
    for first in 0..rows {
        if grouped[first] {
            continue;
        }
        grouped[first] = true;
        let (mut group, mut partners) = (vec![first], Vec::new());
        let mut next = 0;
        while let Some(&row) = group.get(next) {
            next += 1;
            for column in (0..columns).filter(|&column| near(row, column)) {
                if !std::mem::replace(&mut taken[column], true) {
                    partners.push(column);
                    for other in (0..rows).filter(|&other| near(other, column)) {
                        if !std::mem::replace(&mut grouped[other], true) {
                            group.push(other);
                        }
                    }
                }
            }
        }
        if !partners.is_empty() {
            group.sort_unstable();
            partners.sort_unstable();
            groups.push((group, partners));
        }
    }
    groups
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use scphd_log::noise::Noise;

    /// Compares a distance of two sets with those of an independent implementation.
    pub(crate) fn check_oracle(name: &str, distance: impl Fn(&[Vec<f64>], &[Vec<f64>], &Cutoff) -> f64) {
        let oracle = scphd_shared_data::oracle("ospa_gospa.json");
        for case in oracle["cases"].as_array().unwrap() {
            let set = |name: &str| -> Vec<Vec<f64>> {
                case[name].as_array().unwrap().iter().map(scphd_shared_data::numbers).collect()
            };
            let cutoff = Cutoff::new(case["p"].as_f64().unwrap(), case["c"].as_f64().unwrap());
            let found = distance(&set("X"), &set("Y"), &cutoff);
            assert!((found - case[name].as_f64().unwrap()).abs() < 1e-9, "{case}");
        }
    }

    #[test]
    fn groups_solved_separately_have_the_total_cost() {
        let mut noise = Noise::new(11);
        for case in 0..200 {
            let mut set =
                |n: usize| -> Vec<[f64; 2]> { (0..n).map(|_| [0; 2].map(|_| 5.0 * noise.normal())).collect() };
            let (x, y) = (set(case % 23), set((case * 7) % 31));
            let cutoff = Cutoff::new([1.0, 2.0][case % 2], [1.0, 3.0, 40.0][case % 3]);
            let costs: Vec<f64> = x.iter().flat_map(|a| y.iter().map(|b| cutoff.power(cutoff.between(a, b)))).collect();
            let together: f64 =
                assign(&costs, x.len(), y.len()).into_iter().map(|(row, column)| costs[row * y.len() + column]).sum();
            let apart: f64 = cutoff.matched(&x, &y).into_iter().map(|distance| cutoff.power(distance)).sum();
            assert!((together - apart).abs() <= 1e-12 * together.max(1.0), "{together} {apart}");
        }
    }

    #[test]
    fn pairs_are_near_and_used_once() {
        let cutoff = Cutoff::new(1.0, 1.0);
        let pairs = cutoff.pairs(&[[0.0], [0.8], [9.0]], &[[0.7], [1.5], [5.0], [f64::NAN]]);
        assert_eq!(
            pairs.iter().map(|&(a, b, _)| (a, b)).collect::<Vec<_>>(),
            [(1, 0)],
            "0.1 and two unmatched beat 0.7 + 0.7 by nothing to spare"
        );
        let crossed = cutoff.pairs(&[[0.0], [0.8]], &[[0.5], [1.0]]);
        assert_eq!(crossed.iter().map(|&(a, b, _)| (a, b)).collect::<Vec<_>>(), [(0, 0), (1, 1)]);
    }
}

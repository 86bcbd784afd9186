//! The sparsity pattern of the Jacobian, which a model gives to the stiff method; groups of columns
//! that one evaluation computes together, and an order of states with non-zeros near the diagonal.

/// The states that each derivative reads, which are the non-zeros of the Jacobian.
#[derive(Clone, Debug)]
pub struct SparsityPattern {
    /// For each column, the start of its part of `rows`; one more at the end.
    starts: Vec<usize>,
    /// Derivatives that read the state of the column.
    rows: Vec<usize>,
}

impl SparsityPattern {
    /// Each of `n` derivatives reads all states.
    #[must_use]
    pub fn full(n: usize) -> Self {
        Self {
            starts: (0..=n).map(|j| j * n).collect(),
            rows: (0..n).flat_map(|_| 0..n).collect(),
        }
    }

    /// Of `n` states: derivative i reads state j for each of the pairs (i, j).
    ///
    /// # Panics
    /// A number is not below `n`.
    #[must_use]
    pub fn new(n: usize, pairs: impl IntoIterator<Item = (usize, usize)>) -> Self {
        let mut columns = vec![Vec::new(); n];
        for (i, j) in pairs {
            assert!(i < n && j < n, "({i}, {j}) of {n} states");
            columns[j].push(i);
        }
        let (mut starts, mut rows) = (vec![0], Vec::new());
        for mut column in columns {
            column.sort_unstable();
            column.dedup();
            rows.extend(column);
            starts.push(rows.len());
        }
        Self { starts, rows }
    }

    pub(crate) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    pub(crate) fn non_zeros(&self) -> usize {
        self.rows.len()
    }

    /// The non-zeros of a column: their positions among all, and their rows.
    pub(crate) fn column(&self, j: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        (self.starts[j]..self.starts[j + 1]).map(|place| (place, self.rows[place]))
    }

    fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (0..self.len()).flat_map(|j| self.column(j).map(move |(_, i)| (i, j)))
    }

    /// Groups of columns without a common row, so that one directional derivative gives a whole
    /// group; each takes as many columns as fit (Curtis, Powell and Reid, 1974).
    pub(crate) fn groups(&self) -> Vec<Vec<usize>> {
        let mut left: Vec<usize> = (0..self.len()).collect();
        let mut last = vec![usize::MAX; self.len()];
        let mut groups = Vec::new();
        while !left.is_empty() {
            let number = groups.len();
            let mut group = Vec::new();
            left.retain(|&j| {
                let is_free = self.column(j).all(|(_, i)| last[i] != number);
                if is_free {
                    self.column(j).for_each(|(_, i)| last[i] = number);
                    group.push(j);
                }
                !is_free
            });
            groups.push(group);
        }
        groups
    }

    /// The position of each state in the order with the narrower band, unchanged or by Cuthill and
    /// McKee (1969), and the number of diagonals below and above the main one.
    pub(crate) fn order(&self) -> (Vec<usize>, usize, usize) {
        let same: Vec<usize> = (0..self.len()).collect();
        let [a, b] = [same, self.cuthill_mckee()].map(|places| {
            let (lower, upper) = self.band(&places);
            (places, lower, upper)
        });
        if b.1 + b.2 < a.1 + a.2 { b } else { a }
    }

    fn band(&self, places: &[usize]) -> (usize, usize) {
        self.pairs().fold((0, 0), |(lower, upper), (i, j)| {
            let (i, j) = (places[i], places[j]);
            (
                lower.max(i.saturating_sub(j)),
                upper.max(j.saturating_sub(i)),
            )
        })
    }

    /// Breadth-first from a state with few neighbours; neighbours with few of their own come first.
    fn cuthill_mckee(&self) -> Vec<usize> {
        let n = self.len();
        let mut neighbours = vec![Vec::new(); n];
        for (i, j) in self.pairs().filter(|(i, j)| i != j) {
            neighbours[i].push(j);
            neighbours[j].push(i);
        }
        for of in &mut neighbours {
            of.sort_unstable();
            of.dedup();
        }
        let degree: Vec<usize> = neighbours.iter().map(Vec::len).collect();
        for of in &mut neighbours {
            of.sort_by_key(|&j| degree[j]);
        }
        let mut starts: Vec<usize> = (0..n).collect();
        starts.sort_by_key(|&j| degree[j]);
        let mut places = vec![usize::MAX; n];
        let mut order = Vec::with_capacity(n);
        for start in starts {
            let mut next = order.len();
            if places[start] == usize::MAX {
                places[start] = next;
                order.push(start);
            }
            while next < order.len() {
                for &j in &neighbours[order[next]] {
                    if places[j] == usize::MAX {
                        places[j] = order.len();
                        order.push(j);
                    }
                }
                next += 1;
            }
        }
        places
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(n: usize, place: impl Fn(usize) -> usize) -> SparsityPattern {
        let near = move |i: usize| (i.saturating_sub(1)..(i + 2).min(n)).map(move |j| (i, j));
        SparsityPattern::new(n, (0..n).flat_map(near).map(|(i, j)| (place(i), place(j))))
    }

    #[test]
    fn a_chain_needs_three_evaluations_and_one_diagonal_on_each_side() {
        let pattern = chain(50, |i| i);
        assert_eq!(pattern.non_zeros(), 148);
        assert_eq!(pattern.groups().len(), 3);
        assert_eq!(pattern.order(), ((0..50).collect(), 1, 1));
    }

    /// The numbers of a chain in disorder: its band is found again.
    #[test]
    fn states_in_disorder_are_ordered() {
        let pattern = chain(101, |i| i * 37 % 101);
        let (places, lower, upper) = pattern.order();
        assert_eq!((lower, upper), (1, 1));
        let mut all = places.clone();
        all.sort_unstable();
        assert_eq!(all, (0..101).collect::<Vec<_>>());
    }

    #[test]
    fn no_two_columns_of_a_group_share_a_row() {
        let pattern = SparsityPattern::new(
            60,
            (0..60).flat_map(|i| [(i, i), (i, i * i % 60), (i * 7 % 60, i)]),
        );
        let groups = pattern.groups();
        assert_eq!(groups.iter().map(Vec::len).sum::<usize>(), 60);
        for group in &groups {
            let mut rows: Vec<_> = group
                .iter()
                .flat_map(|&j| pattern.column(j).map(|(_, i)| i))
                .collect();
            let all = rows.len();
            rows.sort_unstable();
            rows.dedup();
            assert_eq!(rows.len(), all);
        }
        assert_eq!(SparsityPattern::full(9).groups().len(), 9);
        assert_eq!(SparsityPattern::full(9).order().1, 8);
    }
}

//! Finds the parts of a directed graph whose nodes all reach each other, for `order`: outputs that
//! are in such a part are in an algebraic loop.

/// The strongly connected parts of a graph, each after the parts that it leads to, with the node
/// that was visited first as its first (Tarjan 1972, without recursion). `edges` has the nodes that
/// each node leads to.
pub fn strong_parts(edges: &[Vec<usize>]) -> Vec<Vec<usize>> {
    const NEW: usize = usize::MAX;
    let (mut number, mut lowest) = (vec![NEW; edges.len()], vec![NEW; edges.len()]);
    let mut is_open = vec![false; edges.len()];
    let (mut open, mut parts, mut count) = (Vec::new(), Vec::new(), 0);
    // Nodes on the way from the start, with the number of their edges that were followed.
    let mut way: Vec<(usize, usize)> = Vec::new();
    for start in 0..edges.len() {
        if number[start] == NEW {
            way.push((start, 0));
        }
        while let Some((node, followed)) = way.last_mut() {
            let node = *node;
            if *followed == 0 {
                (number[node], lowest[node], is_open[node]) = (count, count, true);
                open.push(node);
                count += 1;
            }
            if let Some(next) = edges[node].get(*followed) {
                *followed += 1;
                if number[*next] == NEW {
                    way.push((*next, 0));
                } else if is_open[*next] {
                    lowest[node] = lowest[node].min(number[*next]);
                }
                continue;
            }
            way.pop();
            if let Some((before, _)) = way.last() {
                lowest[*before] = lowest[*before].min(lowest[node]);
            }
            if lowest[node] == number[node] {
                let first = open.iter().rposition(|other| *other == node);
                let part = open.split_off(first.unwrap_or_default());
                part.iter().for_each(|node| is_open[*node] = false);
                parts.push(part);
            }
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_follow_those_that_they_lead_to() {
        // 0 -> 1 <-> 2 -> 3, 4 -> 4, 5 -> 0 and 3.
        let edges = [vec![1], vec![2], vec![1, 3], vec![], vec![4], vec![0, 3]];
        let expected = [vec![3], vec![1, 2], vec![0], vec![4], vec![5]];
        assert_eq!(strong_parts(&edges), expected);
        // A long chain does not exhaust the stack.
        let chain: Vec<_> = (1..1_000_000).map(|k| vec![k]).chain([vec![]]).collect();
        assert_eq!(strong_parts(&chain).len(), 1_000_000);
    }
}

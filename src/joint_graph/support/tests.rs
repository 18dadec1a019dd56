use super::*;

/// A small generator for tests: numbers below `n` (xorshift).
struct Random(u64);

impl Random {
    fn below(&mut self, n: u32) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 33) as u32 % n
    }

    fn between(&mut self, from: f32, to: f32) -> f32 {
        from + (to - from) * self.below(1 << 20) as f32 / (1 << 20) as f32
    }
}

/// A face of a box of width 2 (m) whose centre is `shift` beside the lower body's and `offset` beside the upper one's.
fn face(lower: u32, upper: u32, shift: f32, offset: f32, half: f32) -> SupportLink {
    let corner = |x: f32, y: f32| Vec2::new(shift + x * half, y * half);
    SupportLink {
        lower,
        upper,
        points: [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        count: 4,
        offset: Vec2::new(offset, 0.0),
        slack: 0.0,
        holds: true,
        pair: 0,
    }
}

fn graph_of(bodies: u32) -> SupportGraph {
    let mut graph = SupportGraph::default();
    graph.set_kind(0, NodeKind::Ground);
    for body in 1..=bodies {
        graph.set_kind(body, NodeKind::Body);
    }
    graph
}

fn supported(graph: &SupportGraph) -> Vec<bool> {
    graph.nodes.iter().map(SupportNode::is_supported).collect()
}

#[test]
fn the_three_cases_of_the_figure() {
    // Inside the hull below, outside of it, and on something that slides.
    for (shift, slides, expected) in [(0.3, false, true), (1.4, false, false), (0.3, true, false)] {
        let mut graph = graph_of(2);
        graph.insert(SupportLink { holds: !slides, ..face(0, 1, 0.0, 0.0, 0.5) });
        let top = graph.insert(face(1, 2, shift, -shift, 0.2));
        graph.update();
        assert_eq!(graph.is_supporting(top), expected, "shift {shift} m, slides {slides}");
        assert_eq!(graph.nodes[2].is_supported(), expected, "shift {shift} m, slides {slides}");
        assert_eq!(graph.nodes[1].is_supported(), !slides);
    }
}

#[test]
fn a_wide_face_on_a_narrow_post_carries_what_stands_over_the_post() {
    let mut graph = graph_of(3);
    graph.insert(face(0, 1, 0.0, 0.0, 0.1));
    graph.insert(face(1, 2, 0.0, 0.0, 2.0));
    graph.insert(face(2, 3, 0.0, 0.0, 2.0));
    graph.update();
    assert_eq!(supported(&graph)[1..], [true, true, true]);
    assert!((graph.nodes[3].margin - 0.1).abs() < 1e-6, "margin {} m over a post of half width 0.1 m", graph.nodes[3].margin);
}

#[test]
fn what_stands_on_itself_alone_is_not_supported() {
    let mut graph = graph_of(3);
    for (lower, upper) in [(1, 2), (2, 3), (3, 1)] {
        graph.insert(face(lower, upper, 0.0, 0.0, 1.0));
    }
    graph.update();
    assert_eq!(supported(&graph), [false; 4]);
    let ground = graph.insert(face(0, 2, 0.0, 0.0, 1.0));
    graph.update();
    assert!(graph.nodes[2].is_supported());
    graph.remove(ground);
    graph.update();
    assert_eq!(supported(&graph), [false; 4], "a circle does not hold itself up when the ground is gone");
}

#[test]
fn joints_hold_what_hangs_and_let_go_of_what_falls() {
    let mut graph = graph_of(5);
    graph.insert(face(0, 1, 0.0, 0.0, 1.0));
    // 1 stands; 2 hangs on it, and 3 stands on 2; 4 and 5 hang on each other alone.
    graph.insert(face(2, 3, 0.0, 0.0, 1.0));
    graph.set_joints(&[(1, 2), (4, 5)], &[]);
    graph.update();
    assert_eq!(supported(&graph)[1..], [true, true, true, false, false]);
    graph.set_joints(&[(1, 2), (4, 5)], &[5]);
    graph.update();
    assert_eq!(supported(&graph)[1..], [true; 5]);
    graph.set_joints(&[], &[]);
    graph.update();
    assert_eq!(supported(&graph)[1..], [true, false, false, false, false]);
}

#[test]
fn a_change_is_followed_upwards_until_nothing_differs() {
    let mut graph = graph_of(100);
    let mut links = Vec::new();
    for body in 1..=100 {
        links.push(graph.insert(face(body - 1, body, 0.0, 0.0, 1.0)));
    }
    graph.update();
    assert_eq!(graph.evaluated(), 100);
    // A second contact beside the first changes no hull above it.
    graph.insert(face(49, 50, 0.1, 0.0, 0.5));
    graph.update();
    assert_eq!(graph.evaluated(), 1);
    graph.remove(links[70]);
    graph.update();
    assert_eq!((graph.evaluated(), graph.changed().len()), (30, 30));
}

#[test]
fn kept_up_graphs_equal_full_analyses_over_a_thousand_edit_sequences() {
    let mut longest = 0;
    for sequence in 0..1000_u64 {
        let mut random = Random(0x9E37_79B9_7F4A_7C15 ^ ((sequence + 1) * 7919));
        let count = 3 + random.below(12);
        let mut graph = graph_of(count);
        let (mut links, mut ties, mut anchors) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..40 {
            match random.below(12) {
                0..6 => {
                    // Mostly upwards, at times in circles.
                    let (a, b) = (random.below(count + 1), random.below(count) + 1);
                    let (lower, upper) = if random.below(8) == 0 { (a, b) } else { (a.min(b), a.max(b)) };
                    if lower != upper && upper != 0 {
                        let half = random.between(0.1, 1.5);
                        let link = face(lower, upper, random.between(-1.0, 1.0), random.between(-0.5, 0.5), half);
                        links.push(graph.insert(SupportLink {
                            count: random.below(4) as u8 + 1,
                            holds: random.below(6) > 0,
                            ..link
                        }));
                    }
                }
                6..9 if !links.is_empty() => {
                    let at = random.below(links.len() as u32) as usize;
                    graph.remove(links.swap_remove(at));
                }
                9 => {
                    let (a, b) = (random.below(count) + 1, random.below(count) + 1);
                    if a != b {
                        ties.push((a, b));
                    }
                    graph.set_joints(&ties, &anchors);
                }
                10 => {
                    ties.pop();
                    anchors.clear();
                    if random.below(2) == 0 {
                        anchors.push(random.below(count) + 1);
                    }
                    graph.set_joints(&ties, &anchors);
                }
                _ => graph.set_kind(0, if random.below(3) == 0 { NodeKind::Moving } else { NodeKind::Ground }),
            }
            let before = supported(&graph);
            graph.update();
            let changed: Vec<u32> = (0..=count).filter(|&b| before[b as usize] != supported(&graph)[b as usize]).collect();
            let mut full = graph.clone();
            full.update_all();
            for (body, (kept, full)) in graph.nodes.iter().zip(&full.nodes).enumerate().skip(1) {
                assert_eq!(
                    (&kept.hull, kept.held_by_joints),
                    (&full.hull, full.held_by_joints),
                    "sequence {sequence}, body {body}"
                );
                assert_eq!(kept.margin.to_bits(), full.margin.to_bits(), "sequence {sequence}, body {body}");
            }
            assert!(changed.iter().all(|body| graph.changed().contains(body)), "sequence {sequence}: {changed:?}");
            longest = longest.max(supported(&graph).iter().filter(|&&is| is).count());
        }
    }
    assert!(longest >= 8, "at most {longest} bodies were supported at once: the sequences say little");
}

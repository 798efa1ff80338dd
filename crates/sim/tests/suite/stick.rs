//! The operator's sticks against time.

use hydrocrane_control::interface::controller::{Goal, Stick};
use hydrocrane_sim::inputs::stick::{Hand, ROUNDING};
use hydrocrane_sim::{StickKind, Sticks};

fn sticks(linear: bool, dead_zone: f64, ramp: f64) -> Sticks {
    let (times, deflections) = (vec![1.0, 2.0], vec![0.0, 1.0, 1.0, -1.0]);
    Sticks { times, deflections, linear, dead_zone, ramp, ..Sticks::centred(StickKind::Tip, 2) }
}

#[test]
fn held_and_straight_between_the_rows() {
    let at = |linear, t| Hand::new(sticks(linear, 0.0, 0.0), 0.0).move_to(t).to_vec();
    assert_eq!(at(false, 0.5), [0.0, 0.0]);
    assert_eq!(at(false, 1.5), [0.0, 1.0]);
    assert_eq!(at(true, 1.5), [0.5, 0.0]);
    assert_eq!(at(true, 9.0), [1.0, -1.0]);
}

#[test]
fn rounding_does_not_lead_past_the_end_of_a_stick() {
    // The row begins a rounding error after the sample that it is meant for.
    let begin = 0.1 + 0.2;
    for (end, dead_zone, ramp) in [(1.0, 0.0, 0.0), (1.0, 0.1, 0.05), (1.0 + 0.5 * ROUNDING, 0.0, 0.0)] {
        let (times, deflections) = (vec![0.2, begin, 0.31], vec![end, -end, end, -end, -end, end]);
        let mut hand = Hand::new(Sticks { times, deflections, ..sticks(true, dead_zone, ramp) }, 0.0);
        for t in [0.0, 0.2, 0.25, 0.3, begin, 0.305, 0.31] {
            let at = hand.move_to(t);
            assert!(at.iter().all(|d| d.abs() <= 1.0), "{at:?} at {t} s");
        }
    }
}

#[test]
fn the_dead_zone_leaves_full_deflection_full() {
    let zoned = sticks(true, 0.2, 0.0);
    assert_eq!(Hand::new(zoned.clone(), 0.0).move_to(2.0), [1.0, -1.0]);
    assert!((Hand::new(zoned.clone(), 0.0).move_to(1.6)[0] - 0.5).abs() < 1e-12);
    assert_eq!(Hand::new(zoned.clone(), 0.0).move_to(1.58)[1], 0.0, "0.16 backwards is inside the zone");
}

#[test]
fn a_ramp_limits_the_speed_of_the_stick() {
    let ramped = sticks(false, 0.0, 0.2);
    let mut hand = Hand::new(ramped, 0.0);
    hand.move_to(0.99);
    assert!((hand.move_to(1.04)[1] - 0.25).abs() < 1e-12);
    assert_eq!(hand.move_to(1.5)[1], 1.0);
}

#[test]
fn straight_sticks_taken_over_are_held_as_the_samples_saw_them() {
    let samples = || (0..=3).map(|k| 0.9 + 0.3 * f64::from(k));
    let mut hand = Hand::new(sticks(true, 0.2, 0.0), 0.0);
    let before: Vec<_> = samples().map(|t| hand.move_to(t).to_vec()).collect();
    hand.forget_after(samples());
    assert!(!hand.sticks().linear && hand.sticks().times.len() == 4, "{:?}", hand.sticks());
    let after: Vec<_> = samples().map(|t| hand.move_to(t).to_vec()).collect();
    assert_eq!(before, after);
    assert_eq!(hand.move_to(9.0), before[3], "what was to come is forgotten");
}

#[test]
fn what_a_hand_holds_is_written_down_where_it_changes() {
    let mut hand = Hand::new(Sticks::centred(StickKind::Tip, 2), 0.0);
    for (t, z) in [(0.0, 0.5), (0.1, 0.5), (0.2, -0.5)] {
        hand.hold(t, &[0.0, z], 1.0);
        assert_eq!(hand.move_to(t), [0.0, z]);
    }
    assert_eq!(hand.sticks().times, [0.0, 0.2]);
    assert!(hand.sticks().precision.is_empty(), "nothing was said of it");
    hand.hold(0.3, &[0.0, -0.5], 0.25);
    hand.hold(0.4, &[0.0, -0.5], 1.0);
    assert_eq!(
        (&hand.sticks().times[2..], &hand.sticks().precision[..]),
        (&[0.3, 0.4][..], &[1.0, 1.0, 0.25, 1.0][..])
    );
    assert_eq!((hand.move_to(0.35)[1], hand.move_to(0.45)[1]), (-0.125, -0.5));
}

#[test]
fn precision_slows_the_stick_through_its_ramp() {
    let slower = Sticks { precision: vec![1.0, 0.25], ..sticks(false, 0.2, 0.5) };
    let mut hand = Hand::new(slower, 0.0);
    assert_eq!(hand.move_to(1.9)[1], 1.0);
    assert!((hand.move_to(2.1)[0] - 0.25).abs() < 1e-12);
    assert!((hand.at()[1] - 0.6).abs() < 1e-12, "on the way from 1 to -0.25");
}

fn goal(given: f64, x: f64) -> Goal {
    Goal { place: [x, 0.0], speed: None, share: 1.0, given, until: f64::INFINITY }
}

/// To where the controller is sent at each time.
fn sent(hand: &mut Hand, times: &[f64]) -> Vec<Option<f64>> {
    let at = |t: &f64| {
        hand.move_to(*t);
        match hand.stick() {
            Stick::Goal(goal) => Some(goal.place[0]),
            _ => None,
        }
    };
    times.iter().map(at).collect()
}

#[test]
fn a_goal_holds_until_the_next_one_or_until_a_stick_is_moved() {
    // The sticks are centred until 1 s and from 2 s on.
    let (times, deflections) = (vec![1.0, 2.0], vec![0.5, 0.0, 0.0, 0.0]);
    let goals = vec![goal(0.1, 1.0), goal(0.5, 2.0), goal(1.5, 3.0), goal(3.0, 4.0)];
    let plan = Sticks { times, deflections, goals, ..sticks(false, 0.0, 0.5) };
    let mut hand = Hand::new(plan.clone(), 0.0);
    assert_eq!(sent(&mut hand, &[0.0, 0.1, 0.4, 0.5, 0.9]), [None, Some(1.0), Some(1.0), Some(2.0), Some(2.0)]);
    assert_eq!((sent(&mut hand, &[1.0, 1.4]), hand.refused()), (vec![None; 2], None));
    assert_eq!((sent(&mut hand, &[1.5]), hand.refused()), (vec![None], Some(goal(1.5, 3.0))));
    assert_eq!(sent(&mut hand, &[2.5, 3.0]), [None, Some(4.0)], "a stick that is released starts nothing");
    hand.arrive();
    assert_eq!(sent(&mut hand, &[3.1]), [None]);
    // Another phase with the same goals starts none of them again; another operator's plan has its own.
    hand.take(plan.clone(), 3.2);
    assert_eq!(sent(&mut hand, &[3.3]), [None]);
    hand.take(Sticks { goals: vec![goal(4.0, 5.0)], ..plan }, 3.5);
    assert_eq!(sent(&mut hand, &[3.6, 4.0]), [None, Some(5.0)]);
    assert_eq!(hand.sticks().goals.len(), 5);
    hand.forget_after([3.9].into_iter());
    assert_eq!((sent(&mut hand, &[4.1]), hand.sticks().goals.len()), (vec![None], 4));
}

#[test]
fn a_goal_that_is_dropped_is_past_from_then_on_and_again_when_repeated() {
    let mut hand = Hand::new(Sticks::centred(StickKind::Tip, 2), 0.0);
    hand.drop_goal(0.0);
    assert!(hand.sticks().idle(), "there is none to drop");
    hand.go_to(goal(0.1, 1.0));
    assert_eq!(sent(&mut hand, &[0.1, 0.2]), [Some(1.0); 2]);
    hand.drop_goal(0.3);
    assert_eq!(sent(&mut hand, &[0.3, 0.4]), [None; 2]);
    let mut again = Hand::new(hand.sticks().clone(), 0.0);
    assert_eq!(sent(&mut again, &[0.1, 0.2, 0.3]), [Some(1.0), Some(1.0), None]);
    again.go_to(goal(0.5, 2.0));
    assert_eq!(sent(&mut again, &[0.5]), [Some(2.0)]);
    // Somebody who takes over a replay has not dropped the goal yet.
    let mut taken = Hand::new(hand.sticks().clone(), 0.0);
    assert_eq!(sent(&mut taken, &[0.2]), [Some(1.0)]);
    taken.forget_after([0.2].into_iter());
    assert_eq!(sent(&mut taken, &[0.3]), [Some(1.0)]);
}

//! The report of a released grasp.

use serde::Serialize;

use super::grip::{GraspContact, Grip, toward_link};
use super::hand::Hand;
use super::options::ReleaseOptions;
use super::quality::{GraspQuality, quality};
use crate::collision::contacts_within;
use crate::cspace::Config;
use crate::query::Context;
use crate::query::evaluate::Evaluator;

/// A hand that holds an object and penetrates nothing.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Grasp {
    /// Configuration of all joints.
    pub config: Config,
    /// Distance from the query, in the scene's metric.
    pub moved: f64,
    /// Whether the exact checker called it free during this call: every checked pair keeps the
    /// clearance, and every joint its limits.
    pub verified: bool,
    /// Contacts with the object, link by link.
    pub contacts: Vec<GraspContact>,
    /// Names of the links that touched the object, or were in it, at the query.
    pub touched: Vec<String>,
    /// Names of those links that still touch it.
    pub kept: Vec<String>,
    /// Number of fingers that touched at the query, and of those that still do.
    pub fingers: [usize; 2],
    /// Whether every kept contact is on its side of the object: its normal differs by less than 90
    /// degrees from that of the first touch when the finger closes from open.
    pub kept_sides: bool,
    /// Greatest signed depth \[m\] of a link in the object at the query; 0 if none was in it.
    pub depth_before: f64,
    /// How well the object is held; `None` if no friction was given.
    pub quality: Option<GraspQuality>,
    /// Number of exact checks and contact evaluations.
    pub checks: usize,
}

/// Measures a configuration that was found.
pub(super) fn report(
    hand: &Hand,
    context: &Context,
    options: &ReleaseOptions,
    (before, touched): (&Grip, &[bool]),
    (config, moved, kept_sides): (Vec<f64>, f64, bool),
    evaluator: &mut Evaluator,
) -> Grasp {
    let scene = context.checker.scene();
    let verified = evaluator.label(context, &config) == crate::cspace::Label::Free;
    let now = Grip::at(hand, context, &config, Some(options.touch), &mut evaluator.check);
    let touching = now.touching(options.touch);
    let kept: Vec<bool> = touching.iter().zip(touched).map(|(now, then)| *now && *then).collect();
    let names = |links: &[bool]| {
        let named = hand.links.iter().zip(links).filter(|(_, is_one)| **is_one);
        named.map(|(link, _)| scene.bodies[link.body].name.clone()).collect()
    };
    let count = |links: &[bool]| Grip::fingers(hand, links).iter().filter(|is_one| **is_one).count();
    let contacts = contacts_of(hand, context, &config, options.touch, evaluator);
    let quality = options.friction.map(|friction| quality(context, hand.object, &contacts, friction));
    Grasp {
        moved,
        verified,
        touched: names(touched),
        kept: names(&kept),
        fingers: [count(touched), count(&kept)],
        kept_sides,
        depth_before: before.gaps.iter().map(|gap| -(gap + context.clearance)).fold(0.0, f64::max),
        contacts,
        quality,
        checks: evaluator.checks,
        config: Config::trusted(&config),
    }
}

fn contacts_of(
    hand: &Hand,
    context: &Context,
    config: &[f64],
    touch: f64,
    evaluator: &mut Evaluator,
) -> Vec<GraspContact> {
    let mut found = Vec::new();
    contacts_within(context.checker, config, context.clearance + touch, &mut evaluator.check, &mut found);
    let scene = context.checker.scene();
    let of_link = |contact: &crate::collision::Contact| {
        let link = hand.links.iter().find(|link| link.pair == contact.pair)?;
        Some(GraspContact {
            link: scene.bodies[link.body].name.clone(),
            distance: contact.distance,
            point: if link.is_second { contact.point_first } else { contact.point_second }.into(),
            normal: (-toward_link(link, contact)).into(),
        })
    };
    found.iter().filter_map(of_link).collect()
}

//! Queries in another world, and constraints on answers.

use crate::process::{COLLIDING, Workspace};

const WORLD: &str = "[[obstacle]]\nname = 'ball'\nshape = { sphere = 0.1 }\npose = { xyz = [0.6, -0.3, 0] }\n\
                     [[attached]]\nname = 'tool'\nlink = 'fore'\nshape = { sphere = 0.05 }\npose = { xyz = [0.55, 0, 0] }\n";

fn q(config: &str) -> String {
    config.trim_matches(['[', ']']).replace(' ', "")
}

#[test]
fn a_world_replaces_the_obstacles_of_a_scene_or_of_a_model() {
    let workspace = Workspace::learned();
    workspace.write("world.toml", WORLD);
    workspace.write("clear.toml", "");
    for asked in ["scene.toml", "small.model", "planar.urdf"] {
        // The first query goes through the post, which this world does not have; in the second the
        // forearm meets the ball.
        let line = format!("query {asked} --q {} --q -0.31,0.0 --world world.toml --json", q(COLLIDING));
        let answers = workspace.run(&line).expect_code(0).json();
        assert_eq!(answers[0]["depth"], 0.0, "{asked}");
        let colliding = &answers[1]["colliding"];
        assert!(colliding.as_array().unwrap().contains(&serde_json::json!(["fore", "ball"])), "{asked}: {colliding}");
        assert_eq!(answers[1]["verified"], true);
        let line = format!("query {asked} --q -0.25,-1.2 --world world.toml --json");
        let held = &workspace.run(&line).expect_code(0).json()[0];
        assert!(held["depth"].as_f64().unwrap() >= 0.0);
        workspace.run(&format!("query {asked} --q 0.1,0 --world clear.toml")).expect_code(0);
    }
    let line = |world: &str| format!("query scene.toml --q 0.1,0.0 --world {world}");
    workspace.run(&line("planar.urdf")).expect_failure(&["planar.urdf", "got a URDF, expected a scene file"]);
    workspace.write("bad.toml", WORLD.replace("'fore'", "'fire'"));
    workspace.run(&line("bad.toml")).expect_failure(&["bad.toml: attached \"tool\": link: got `fire`", "`fore`"]);
    workspace.run(&line("none.toml")).expect_failure(&["none.toml"]);
    // A whole scene is accepted too.
    workspace.run("query small.model --q 0.1,0.0 --scene scene.toml").expect_code(0);
}

#[test]
fn answers_keep_what_is_asked_of_them() {
    let workspace = Workspace::learned();
    let ask = |asked: &str, more: &str| {
        workspace.run(&format!("query {asked} --q {} --json {more}", q(COLLIDING))).expect_code(0).json().remove(0)
    };
    for asked in ["scene.toml", "small.model"] {
        let plain = ask(asked, "");
        assert_eq!(plain["clearance"], 1e-4);
        let wide = ask(asked, "--clearance 0.02 --free-radius");
        assert_eq!(wide["clearance"], 0.02);
        assert!(
            wide["depth"].as_f64() > plain["depth"].as_f64() && wide["free_radius"].as_f64() > Some(0.005),
            "{wide}"
        );
        let locked = ask(asked, "--locked elbow");
        assert_eq!(locked["witness"][1], 0.0);
        assert_eq!(ask(asked, "--free shoulder")["witness"], locked["witness"]);
        assert!(locked["depth"].as_f64() > plain["depth"].as_f64());
        let heavy = ask(asked, "--weights shoulder=100");
        let turn = |answer: &serde_json::Value| (answer["witness"][0].as_f64().unwrap() - 0.1).abs();
        assert!(turn(&heavy) < turn(&plain), "{heavy} {plain}");
        let goal = ask(asked, "--toward 1.5,0 --toward-share 9");
        assert!(goal["witness"][0].as_f64() > Some(0.1), "{goal}");
    }
    let refused = |more: &str, parts: &[&str]| {
        workspace.run(&format!("query scene.toml --q 0.1,0.0 {more}")).expect_failure(parts);
    };
    refused("--locked elbo", &["--locked", "got `elbo`, expected one of `shoulder`, `elbow`"]);
    refused("--weights elbo=2", &["got `elbo`"]);
    refused("--toward 1", &["--toward: got 1, expected 2 numbers"]);
    // Nothing may move, so there is neither an answer nor a search for one.
    refused("--locked shoulder,elbow", &["no free configuration was found"]);
    workspace.run("query scene.toml --q 0.1,0.0 --locked elbow --free shoulder").expect_code(2);
    workspace.run("query scene.toml --q 0.1,0.0 --weights elbow").expect_code(2);
    let text = workspace.run("query scene.toml --q 0.1,0.0 --clearance 9").expect_code(0).stdout;
    // The excess over the scene's clearance is halved six times until it is kept nearby.
    assert!(text.contains("but  keeps 0.1407234375 m: nothing was found that keeps 9 m nearby"), "{text}");
    let text = workspace.run("query scene.toml --q 0.1,0.0 --free-radius").expect_code(0).stdout;
    assert!(text.contains("nothing touches within"), "{text}");
}

//! Drives a Chromium over `--remote-debugging-pipe`: messages of JSON, each ended by a NUL, no port, no driver.
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

/// What has come and waits to be taken; `None`: the browser is gone.
type Inbox = Arc<(Mutex<Option<Vec<Value>>>, Condvar)>;

/// A browser; it ends when this is dropped.
pub struct Browser {
    child: Child,
    to: Mutex<(ChildStdin, u64)>,
    inbox: Inbox,
    /// Its profile and temporary files.
    folder: tempfile::TempDir,
}

/// A value, or what went wrong in words.
pub type Outcome<T> = Result<T, String>;

impl Browser {
    /// Starts Debian's Chromium without a window.
    pub fn start() -> Outcome<Arc<Self>> {
        let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
        // The browser wants its pipe at 3 and 4; a shell moves it there, so no unsafe code is needed.
        let mut child = Command::new("sh")
            .args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 0</dev/null 1>/dev/null", "chromium"])
            .args([
                "--headless=new",
                "--remote-debugging-pipe",
                "--no-sandbox",
                "--disable-gpu",
                "--disable-quic",
                "--disable-dev-shm-usage",
                "--no-first-run",
                "--no-default-browser-check",
                "--disable-background-networking",
                "--disable-component-update",
                "--disable-extensions",
                "--disable-sync",
                "--mute-audio",
                "--force-color-profile=srgb",
                "--hide-scrollbars",
                "--window-size=1440,900",
            ])
            .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
            .arg("about:blank")
            .env("TMPDIR", folder.path())
            // A group of its own, so that all of it can be stopped at once.
            .process_group(0)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|e| format!("chromium: {e}"))?;
        let (to, from) = (child.stdin.take().ok_or("stdin")?, child.stdout.take().ok_or("stdout")?);
        let inbox: Inbox = Arc::new((Mutex::new(Some(Vec::new())), Condvar::new()));
        let filled = inbox.clone();
        std::thread::spawn(move || {
            let mut from = BufReader::new(from);
            let mut raw = Vec::new();
            while {
                raw.clear();
                from.read_until(0, &mut raw).is_ok_and(|n| n > 1)
            } {
                raw.pop();
                let Ok(message) = serde_json::from_slice(&raw) else { continue };
                if let Some(all) = filled.0.lock().unwrap().as_mut() {
                    all.push(message);
                }
                filled.1.notify_all();
            }
            *filled.0.lock().unwrap() = None;
            filled.1.notify_all();
        });
        Ok(Arc::new(Self { child, to: Mutex::new((to, 0)), inbox, folder }))
    }
    /// The browser's process.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }
    /// Takes the first message that `fits` out of the inbox.
    fn take(&self, patience: Duration, mut fits: impl FnMut(&Value) -> bool) -> Outcome<Value> {
        let until = Instant::now() + patience;
        let mut all = self.inbox.0.lock().unwrap();
        loop {
            let list = all.as_mut().ok_or("the browser is gone")?;
            if let Some(at) = list.iter().position(&mut fits) {
                return Ok(list.remove(at));
            }
            let left = until.checked_duration_since(Instant::now()).ok_or("no answer in time")?;
            all = self.inbox.1.wait_timeout(all, left).unwrap().0;
        }
    }
    /// Calls a method of the protocol.
    pub fn call(&self, session: Option<&str>, method: &str, params: Value) -> Outcome<Value> {
        let id = {
            let mut to = self.to.lock().unwrap();
            to.1 += 1;
            let mut message = json!({ "id": to.1, "method": method, "params": params });
            if let Some(session) = session {
                message["sessionId"] = session.into()
            }
            let id = to.1;
            to.0.write_all(format!("{message}\0").as_bytes())
                .map_err(|e| format!("{method}: {e}"))?;
            id
        };
        let answer = self
            .take(Duration::from_secs(30), |m| m["id"] == id)
            .map_err(|e| format!("{method}: {e}"))?;
        if answer["error"].is_null() {
            Ok(answer["result"].clone())
        } else {
            Err(format!("{method}: {}", answer["error"]["message"]))
        }
    }
    /// A new page at an address.
    pub fn page(self: &Arc<Self>, url: &str) -> Outcome<Page> {
        let target =
            self.call(None, "Target.createTarget", json!({ "url": "about:blank" }))?["targetId"]
                .clone();
        let session = self.call(
            None,
            "Target.attachToTarget",
            json!({ "targetId": target, "flatten": true }),
        )?["sessionId"]
            .as_str()
            .ok_or("session")?
            .to_owned();
        let page = Page {
            browser: self.clone(),
            session,
            target: target.as_str().unwrap_or("").to_owned(),
        };
        page.call("Page.enable", json!({}))?;
        page.call("Runtime.enable", json!({}))?;
        page.call("Page.setLifecycleEventsEnabled", json!({ "enabled": true }))?;
        page.go(url)?;
        Ok(page)
    }
}
impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        // Its children may still write for a moment.
        for _ in 0..20 {
            if std::fs::remove_dir_all(self.folder.path()).is_ok() {
                break;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

/// A page of a browser.
pub struct Page {
    browser: Arc<Browser>,
    session: String,
    target: String,
}

impl Page {
    /// Calls a method for this page.
    pub fn call(&self, method: &str, params: Value) -> Outcome<Value> {
        self.browser.call(Some(&self.session), method, params)
    }
    /// The next event of a kind.
    pub fn event(&self, method: &str, patience: Duration) -> Outcome<Value> {
        self.browser.take(patience, |m| m["method"] == method && m["sessionId"] == *self.session)
    }
    /// Goes to an address, and waits until it is loaded.
    pub fn go(&self, url: &str) -> Outcome<()> {
        let loader = self.call("Page.navigate", json!({ "url": url }))?["loaderId"].clone();
        // The load of this navigation, not that of the page before, which may still be on its way.
        let fits = |m: &Value| {
            m["method"] == "Page.lifecycleEvent"
                && m["sessionId"] == *self.session
                && m["params"]["name"] == "load"
                && m["params"]["loaderId"] == loader
        };
        self.browser
            .take(Duration::from_secs(20), fits)
            .map_err(|e| format!("{url}: {e}"))
            .map(drop)
    }
    /// Value of an expression, promises awaited; an exception is an error.
    pub fn eval(&self, js: &str) -> Outcome<Value> {
        let got = self.call("Runtime.evaluate", json!({ "expression": js, "awaitPromise": true, "returnByValue": true, "userGesture": true }))?;
        match got.get("exceptionDetails") {
            Some(e) => Err(format!(
                "{js}: {}",
                e["exception"]["description"].as_str().unwrap_or("exception")
            )),
            None => Ok(got["result"]["value"].clone()),
        }
    }
    /// Waits until an expression is true.
    pub fn wait(&self, js: &str, patience: Duration) -> Outcome<()> {
        let until = Instant::now() + patience;
        while self.eval(js)? != true {
            if Instant::now() > until {
                return Err(format!("never came true: {js}"));
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        Ok(())
    }
    /// Middle of an element, scrolled into sight.
    pub fn centre(&self, selector: &str) -> Outcome<(f64, f64)> {
        let v = self.eval(&format!("(() => {{ const e = document.querySelector({selector:?}); e.scrollIntoView({{block:'nearest'}}); const r = e.getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2] }})()"))?;
        Ok((v[0].as_f64().ok_or("x")?, v[1].as_f64().ok_or("y")?))
    }
    /// A mouse's event: `mousePressed`, `mouseMoved`, `mouseReleased`.
    pub fn mouse(&self, kind: &str, (x, y): (f64, f64)) -> Outcome<()> {
        let buttons = u8::from(kind != "mouseReleased");
        self.call("Input.dispatchMouseEvent", json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": buttons, "clickCount": 1 })).map(drop)
    }
    /// Clicks an element once it stands still: the same box in two frames running. What the page shows above
    /// it meanwhile would move it between the look and the press.
    pub fn click(&self, selector: &str) -> Outcome<()> {
        let still = format!(
            "(async () => {{ const box = () => {{ const r = document.querySelector({selector:?}).getBoundingClientRect(); return [r.x, r.y, r.width, r.height].join() }}; \
             for (let last = '', now = box(), frames = 0; now !== last && frames < 120; frames++) {{ last = now; await new Promise(done => {{ requestAnimationFrame(() => requestAnimationFrame(done)); setTimeout(done, 100) }}); now = box() }} }})()"
        );
        self.centre(selector)?;
        self.eval(&still)?;
        let at = self.centre(selector)?;
        self.mouse("mousePressed", at)?;
        self.mouse("mouseReleased", at)
    }
    /// A finger's event: `touchStart`, `touchMove`, `touchEnd`.
    pub fn touch(&self, kind: &str, points: &[(f64, f64)]) -> Outcome<()> {
        let points: Vec<Value> = points.iter().map(|(x, y)| json!({ "x": x, "y": y })).collect();
        self.call("Input.dispatchTouchEvent", json!({ "type": kind, "touchPoints": points }))
            .map(drop)
    }
    /// A key by its name and code, with modifiers (1 Alt, 2 Ctrl, 4 Meta, 8 Shift).
    pub fn key(
        &self,
        kind: &str,
        key: &str,
        code: &str,
        vk: u32,
        text: &str,
        modifiers: u32,
    ) -> Outcome<()> {
        self.call("Input.dispatchKeyEvent", json!({ "type": kind, "key": key, "code": code, "windowsVirtualKeyCode": vk, "text": text, "modifiers": modifiers })).map(drop)
    }
    /// Presses a key and lets it go.
    pub fn press(&self, key: &str, code: &str, vk: u32, text: &str, modifiers: u32) -> Outcome<()> {
        self.key("keyDown", key, code, vk, text, modifiers)?;
        self.key("keyUp", key, code, vk, "", modifiers)
    }
    /// Selects all of what has the focus.
    pub fn select_all(&self) -> Outcome<()> {
        self.command("a", "KeyA", 65, "selectAll")
    }

    /// Undo, as the browser's own key for it does.
    pub fn undo(&self) -> Outcome<()> {
        self.command("z", "KeyZ", 90, "undo")
    }

    /// A key with Ctrl, and what the browser does at it.
    fn command(&self, key: &str, code: &str, vk: u32, command: &str) -> Outcome<()> {
        let down = json!({
            "type": "keyDown", "key": key, "code": code, "windowsVirtualKeyCode": vk,
            "modifiers": 2, "commands": [command]
        });
        self.call("Input.dispatchKeyEvent", down)?;
        self.key("keyUp", key, code, vk, "", 2)
    }

    /// Types a text key by key.
    pub fn type_text(&self, text: &str) -> Outcome<()> {
        for c in text.chars() {
            match c {
                '\n' => self.press("Enter", "Enter", 13, "\r", 0)?,
                // The codes of signs are those of other keys: `.` would be Delete.
                c => self.press(
                    &c.to_string(),
                    "",
                    if c.is_ascii_alphanumeric() { c.to_ascii_uppercase() as u32 } else { 0 },
                    &c.to_string(),
                    0,
                )?,
            }
        }
        Ok(())
    }
    /// Gives a file to an input for files.
    pub fn choose(&self, selector: &str, file: &Path) -> Outcome<()> {
        let root = self.call("DOM.getDocument", json!({}))?["root"]["nodeId"].clone();
        let asked = json!({ "nodeId": root, "selector": selector });
        let node = self.call("DOM.querySelector", asked)?["nodeId"].clone();
        let given = json!({ "nodeId": node, "files": [file.display().to_string()] });
        self.call("DOM.setFileInputFiles", given).map(drop)
    }
    /// Writes a picture of the page; a small one where the file's name ends in `.webp`.
    pub fn screenshot(&self, file: &Path) -> Outcome<()> {
        let small = file.extension().is_some_and(|end| end == "webp");
        let format = if small {
            json!({ "format": "webp", "quality": 80 })
        } else {
            json!({ "format": "png" })
        };
        let data = self.call("Page.captureScreenshot", format)?;
        let bytes = unbase64(data["data"].as_str().unwrap_or(""));
        std::fs::write(file, bytes).map_err(|e| e.to_string())
    }
    /// Width and height of the window; `mobile` with a finger instead of a mouse.
    pub fn window(&self, width: u32, height: u32, mobile: bool) -> Outcome<()> {
        self.call(
            "Emulation.setDeviceMetricsOverride",
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": mobile }),
        )?;
        self.call("Emulation.setTouchEmulationEnabled", json!({ "enabled": mobile })).map(drop)
    }
    /// Dark or light.
    pub fn theme(&self, dark: bool) -> Outcome<()> {
        let value = if dark { "dark" } else { "light" };
        let feature = json!([{ "name": "prefers-color-scheme", "value": value }]);
        self.call("Emulation.setEmulatedMedia", json!({ "features": feature })).map(drop)
    }

    /// Brings the page to the front.
    pub fn front(&self) -> Outcome<()> {
        self.call("Page.bringToFront", json!({})).map(drop)
    }

    /// Closes the page.
    pub fn close(&self) -> Outcome<()> {
        self.browser.call(None, "Target.closeTarget", json!({ "targetId": self.target })).map(drop)
    }

    /// Name and states of everything with a role, as a screen reader is told, one a line.
    pub fn states(&self, role: &str) -> Outcome<String> {
        let tree = self.call("Accessibility.getFullAXTree", json!({}))?;
        let own = tree["nodes"].as_array().into_iter().flatten();
        let own = own.filter(|n| n["ignored"] != true && n["role"]["value"] == role);
        let told = own.map(|n| {
            let states = n["properties"].as_array().into_iter().flatten().map(|own| {
                let value = &own["value"]["value"];
                let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
                format!(" {}={value}", own["name"].as_str().unwrap_or("?"))
            });
            let name = n["name"]["value"].as_str().unwrap_or("").trim();
            format!("{name}{}\n", states.collect::<String>())
        });
        Ok(told.collect())
    }

    /// Role and name of everything that a screen reader is told, one a line. Browsers differ in the blanks
    /// at a name's ends.
    pub fn roles(&self) -> Outcome<String> {
        let tree = self.call("Accessibility.getFullAXTree", json!({}))?;
        Ok(tree["nodes"]
            .as_array()
            .into_iter()
            .flatten()
            .filter(|n| n["ignored"] != true)
            .map(|n| {
                format!(
                    "{} {:?}\n",
                    n["role"]["value"].as_str().unwrap_or("?"),
                    n["name"]["value"].as_str().unwrap_or("").trim()
                )
            })
            .collect())
    }
}

fn unbase64(text: &str) -> Vec<u8> {
    let (mut out, mut bits, mut n) = (Vec::with_capacity(text.len() * 3 / 4), 0u32, 0);
    for b in text.bytes() {
        let v = match b {
            b'A'..=b'Z' => b - b'A',
            b'a'..=b'z' => b - b'a' + 26,
            b'0'..=b'9' => b - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => break,
        };
        (bits, n) = (bits << 6 | u32::from(v), n + 6);
        if n >= 8 {
            n -= 8;
            out.push((bits >> n) as u8)
        }
    }
    out
}

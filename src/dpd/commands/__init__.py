"""Commands: one module for each group of them; `dpd.commands.main` joins the groups."""

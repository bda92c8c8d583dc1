"""Measured data, and the only door to Universal File Format files. Knows no robot."""

from flexmodal.campaign.blow import Blow as Blow
from flexmodal.campaign.campaign import Campaign as Campaign
from flexmodal.campaign.campaign import CampaignPoint as CampaignPoint
from flexmodal.campaign.campaign import CampaignPosture as CampaignPosture
from flexmodal.campaign.mode_table import ModeTable as ModeTable
from flexmodal.campaign.quality import QualityFlag as QualityFlag
from flexmodal.campaign.read_campaign import CampaignReport as CampaignReport
from flexmodal.campaign.read_campaign import check_campaign as check_campaign
from flexmodal.campaign.read_campaign import read_campaign as read_campaign
from flexmodal.campaign.records import FrfRecords as FrfRecords
from flexmodal.campaign.trial import Trial as Trial
from flexmodal.campaign.trial import Window as Window
from flexmodal.campaign.trial import repeat_groups as repeat_groups
from flexmodal.campaign.uff import write_frf as write_frf
from flexmodal.campaign.write_campaign import write_campaign as write_campaign
